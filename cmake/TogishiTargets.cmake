# The flags that all of our own code is compiled with, and the two ways to declare a part of it.

find_package(Threads REQUIRED)

add_library(togishi_flags INTERFACE)
target_include_directories(togishi_flags INTERFACE ${PROJECT_SOURCE_DIR}/cpp_core ${PROJECT_SOURCE_DIR}/shaders)
target_compile_options(togishi_flags INTERFACE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror
    # g++ 12 raises it falsely for std::string concatenation (GCC bug 105651).
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    # brdf/model.hpp compiles the shared formulas a second time with float meaning double.
    $<$<CXX_COMPILER_ID:Clang>:-Wno-keyword-macro>
    # Results must not depend on what the compiler fuses: the float path is held against the GPU.
    -ffp-contract=off)
target_compile_definitions(togishi_flags INTERFACE GLM_FORCE_XYZW_ONLY GLM_FORCE_SILENT_WARNINGS)
target_link_libraries(togishi_flags INTERFACE Threads::Threads)
if(TOGISHI_SANITIZE)
    target_compile_options(togishi_flags INTERFACE -fsanitize=${TOGISHI_SANITIZE} -fno-omit-frame-pointer
                                                   -fno-sanitize-recover=all)
    target_link_options(togishi_flags INTERFACE -fsanitize=${TOGISHI_SANITIZE})
    if(TOGISHI_SANITIZE STREQUAL "thread")
        # g++ 12 no longer follows initialisations through what the thread sanitizer inserts.
        target_compile_options(togishi_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    endif()
endif()

# togishi_library(name [DEPENDS targets...]): the static library of the current folder, from its *.cpp.
function(togishi_library name)
    cmake_parse_arguments(ARG "" "" "DEPENDS" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
    if(sources)
        add_library(togishi_${name} STATIC ${sources})
        target_link_libraries(togishi_${name} PUBLIC togishi_flags ${ARG_DEPENDS})
    else()
        add_library(togishi_${name} INTERFACE)
        target_link_libraries(togishi_${name} INTERFACE togishi_flags ${ARG_DEPENDS})
    endif()
endfunction()
