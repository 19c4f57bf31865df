# Writes OUTPUT, a C++ source that holds the text of every data file below DATA_DIR:
#   cmake -DDATA_DIR=data -DOUTPUT=embedded_data.cpp -P embed_data.cmake
# The files are read by the same parsers as a user's own; see cpp_core/spectral/embedded_data.hpp.
file(GLOB_RECURSE files RELATIVE ${DATA_DIR} ${DATA_DIR}/*.csv ${DATA_DIR}/*.toml ${DATA_DIR}/LICENSE.*)
list(SORT files)
set(source "// Generated from data/ by cmake/embed_data.cmake.\n#include \"spectral/embedded_data.hpp\"\n\n")
string(APPEND source "namespace togishi {\nnamespace {\nusing namespace std::string_view_literals;\n")
string(APPEND source "constexpr EmbeddedFile files[] = {\n")
foreach(file IN LISTS files)
    file(READ "${DATA_DIR}/${file}" text)
    string(APPEND source "    {\"${file}\"sv,\n")
    string(LENGTH "${text}" length)
    # Compilers limit one literal (MSVC: 16 kB), not what adjacent ones add up to.
    set(begin 0)
    while(begin LESS length)
        string(SUBSTRING "${text}" ${begin} 12000 chunk)
        string(APPEND source "R\"togishi(${chunk})togishi\"\n")
        math(EXPR begin "${begin} + 12000")
    endwhile()
    string(APPEND source "\"\"sv},\n")
endforeach()
string(APPEND source "};\n}  // namespace\n\nstd::span<const EmbeddedFile> embedded_files() { return files; }\n}\n")
file(WRITE ${OUTPUT} "${source}")
