#include "mesh_file/gltf_promises.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/data_uri.hpp"

namespace togishi {
namespace {

using nlohmann::json;
using Bytes = std::vector<unsigned char>;

constexpr std::uint64_t most_json_bytes = std::uint64_t{1} << 30U;
constexpr std::size_t most_json_parts = 1'000'000, most_json_depth = 64;

std::uint32_t little_endian(const char* at) {
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i) value = value << 8U | static_cast<unsigned char>(at[i]);
    return value;
}

template <class Container>
void take_all(ByteSource& source, std::uint64_t count, Container& out) {
    // Never more at once than what has really been read: the size may be a lie of the file system.
    while (count > 0) {
        const auto some = source.peek(std::min<std::uint64_t>(count, ByteSource::most_taken));
        if (some.empty()) {
            throw InputError(source.where(), "size", std::to_string(source.offset()) + " bytes",
                             std::to_string(count) + " bytes more; is it cut off?");
        }
        const std::size_t step = std::min<std::size_t>(some.size(), count);
        out.insert(out.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(step));
        (void)source.skip(step);
        count -= step;
    }
}

/// A parser's memory goes by the number of parts, its stack by their depth.
void check_shape(const std::string& text, const std::string& where) {
    std::size_t depth = 0, parts = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\') ++i;
            if (c == '"') quoted = false;
            continue;
        }
        if (c == '"') quoted = true;
        if (c == '{' || c == '[') ++depth;
        if ((c == '}' || c == ']') && depth > 0) --depth;
        if (c == ',' || c == '{' || c == '[') ++parts;
        if (depth > most_json_depth)
            throw InputError(where, "JSON", "nested deeper than 64", "at most 64 levels");
        if (parts > most_json_parts)
            throw InputError(where, "JSON", "more than 1000000 parts", "at most 1000000 parts");
    }
}

struct Chunks {
    std::string json;
    Bytes binary;
    bool has_binary = false;
};

Chunks read_chunks(ByteSource& source) {
    Chunks out;
    const auto start = source.peek(12);
    if (!start.starts_with("glTF")) {
        if (source.size() > most_json_bytes)
            throw InputError(source.where(), "size", std::to_string(source.size()) + " bytes",
                             "at most 1 GiB of JSON; or a GLB");
        take_all(source, source.left(), out.json);
        return out;
    }
    const auto cut_off = [&](std::uint64_t promised) {
        throw InputError(source.where(), "chunk", std::to_string(promised) + " bytes",
                         "at most " + std::to_string(source.left()) +
                             ", which the file still has; is it cut off?");
    };
    if (start.size() < 12) cut_off(12);
    const std::uint32_t version = little_endian(&start[4]), length = little_endian(&start[8]);
    if (version != 2)
        throw InputError(source.where(), "glTF version", std::to_string(version), "2");
    if (length > source.size()) cut_off(length);
    (void)source.skip(12);
    for (bool first = true; source.left() >= 8; first = false) {
        const auto head = source.peek(8);
        if (head.size() < 8) break;
        const std::uint32_t bytes = little_endian(head.data());
        const std::string type(head.substr(4, 4));
        (void)source.skip(8);
        if (bytes > source.left()) cut_off(bytes);
        if (first && type == "JSON") {
            if (bytes > most_json_bytes) cut_off(bytes);
            take_all(source, bytes, out.json);
        } else if (type == std::string("BIN\0", 4) && !out.has_binary) {
            out.has_binary = true;
            out.binary.reserve(bytes);
            take_all(source, bytes, out.binary);
        } else {
            (void)source.skip(bytes);
        }
    }
    return out;
}

std::string decoded_uri(const std::string& uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const auto digit = [&](std::size_t at) {
            const char c = at < uri.size() ? uri[at] : 'x';
            return c >= '0' && c <= '9'   ? c - '0'
                   : c >= 'a' && c <= 'f' ? c - 'a' + 10
                   : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                          : -1;
        };
        if (uri[i] == '%' && digit(i + 1) >= 0 && digit(i + 2) >= 0) {
            out += static_cast<char>(16 * digit(i + 1) + digit(i + 2));
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

/// A buffer beside the file; never outside its folder.
Bytes read_beside(const std::string& uri, const std::filesystem::path& folder, std::uint64_t bytes,
                  const std::string& where) {
    const std::filesystem::path name(decoded_uri(uri));
    const bool leaves =
        name.is_absolute() || name.empty() ||
        std::any_of(name.begin(), name.end(), [](const auto& p) { return p == ".."; });
    if (leaves || uri.find(':') != std::string::npos)
        throw InputError(where, "uri", shown(uri), "a file in the folder of the glTF file");
    const std::filesystem::path path = folder / name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        throw InputError(where, "uri", shown(uri) + ", which is missing",
                         "an existing file beside the glTF file");
    const std::uint64_t size = std::filesystem::file_size(path, error);
    if (error || size < bytes) {
        throw InputError(where, "byteLength", std::to_string(bytes),
                         "at most the " + std::to_string(size) + " bytes of " + shown(uri));
    }
    std::ifstream in(path, std::ios::binary);
    ByteSource source(in, size, path.string());
    Bytes out;
    out.reserve(bytes);
    take_all(source, bytes, out);
    return out;
}

std::uint64_t byte_length(const json& buffer, const std::string& where) {
    const auto found = buffer.find("byteLength");
    if (found == buffer.end() || !found->is_number_integer() || found->get<double>() < 1 ||
        found->get<double>() > 1e15) {
        throw InputError(where, "byteLength",
                         found == buffer.end() ? "missing" : shown(found->dump()),
                         "a whole number above 0");
    }
    return found->get<std::uint64_t>();
}

void read_buffers(const json& root, Chunks& chunks, const std::filesystem::path& folder,
                  const std::string& file, GltfParts& out) {
    const auto buffers = root.find("buffers");
    if (buffers == root.end() || !buffers->is_array()) return;
    std::vector<std::string> seen;
    seen.reserve(buffers->size());
    for (std::size_t i = 0; i < buffers->size(); ++i) {
        const std::string where = file + ", buffer " + std::to_string(i);
        const json& buffer = (*buffers)[i];
        if (!buffer.is_object()) throw InputError(where, "buffer", "no object", "an object");
        const std::uint64_t bytes = byte_length(buffer, where);
        const auto uri = buffer.find("uri");
        if (uri != buffer.end() && !uri->is_string())
            throw InputError(where, "uri", "no text", "a text");
        const std::string text = uri == buffer.end() ? std::string() : uri->get<std::string>();
        Bytes& data = out.buffers.emplace_back();
        if (is_data_uri(text)) {
            auto held = data_uri_bytes(text);
            if (!held || held->size() != bytes)
                throw InputError(where, "byteLength", std::to_string(bytes),
                                 "as many bytes as its data: URI holds");
            data = std::move(*held);
            continue;
        }
        // The same bytes twice would be memory for nothing, a thousand times an attack.
        if (std::find(seen.begin(), seen.end(), text) != seen.end())
            throw InputError(where, "uri", shown(text) + " again", "each file once");
        seen.push_back(text);
        if (!text.empty()) {
            data = read_beside(text, folder, bytes, where);
        } else if (bytes > chunks.binary.size()) {
            throw InputError(where, "byteLength", std::to_string(bytes),
                             "at most the " + std::to_string(chunks.binary.size()) +
                                 " bytes of the file's binary chunk");
        } else {
            data = std::exchange(chunks.binary, {});
            data.resize(bytes);
        }
    }
}

void check_extensions(const json& root, const std::string& where) {
    const auto required = root.find("extensionsRequired");
    if (required == root.end() || !required->is_array()) return;
    for (const json& item : *required) {
        const std::string name = item.is_string() ? item.get<std::string>() : std::string();
        const bool harmless = name == "KHR_mesh_quantization" ||
                              name.starts_with("KHR_materials") ||
                              name.starts_with("KHR_texture") || name.starts_with("EXT_texture") ||
                              name.starts_with("KHR_lights");
        if (!harmless)
            throw InputError(where, "extensionsRequired", shown(name),
                             "a mesh without compression and without required extensions but "
                             "KHR_mesh_quantization");
    }
}

}  // namespace

GltfParts read_gltf_parts(ByteSource& source, const std::filesystem::path& folder, MeshFile& file) {
    const std::string& where = source.where();
    file.format = source.peek(4).starts_with("glTF") ? "GLB" : "glTF";
    Chunks chunks = read_chunks(source);
    check_shape(chunks.json, where);
    json root = json::parse(chunks.json, nullptr, false);
    chunks.json = {};
    if (root.is_discarded() || !root.is_object())
        throw InputError(where, "JSON", "not well formed", "a JSON object, as glTF 2.0 has it");
    check_extensions(root, where);
    GltfParts out;
    read_buffers(root, chunks, folder, where, out);
    json kept = {{"asset", {{"version", "2.0"}}}};
    for (const char* name : {"bufferViews", "accessors", "meshes", "nodes", "scenes", "scene"}) {
        const auto found = root.find(name);
        if (found != root.end()) kept[name] = std::move(*found);
    }
    for (const char* name : {"bufferViews", "accessors", "meshes", "nodes", "scenes"}) {
        if (!kept.contains(name) || !kept[name].is_array()) continue;
        for (json& item : kept[name]) {
            if (!item.is_object())
                throw InputError(where, name, "not a list of objects", "a list of objects");
            item.erase("extras");
            item.erase("extensions");
        }
    }
    json buffers = json::array();
    for (std::size_t i = 0; i < out.buffers.size(); ++i)
        buffers.push_back({{"byteLength", out.buffers[i].size()}, {"uri", std::to_string(i)}});
    kept["buffers"] = std::move(buffers);
    if (root.contains("images"))
        file.notes.emplace_back("It has textures; they are not read, vertex colours are.");
    // Names in broken UTF-8 are of no interest and no reason to fail.
    out.json = kept.dump(-1, ' ', false, json::error_handler_t::replace);
    return out;
}

}  // namespace togishi
