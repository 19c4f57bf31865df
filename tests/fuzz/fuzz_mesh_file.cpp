// Breaks mesh files in every way for a time and lets each reader have them: nothing but InputError
// may come of it, and the sanitizers must stay silent.
//   fuzz_mesh_file SECONDS [SEED]
// With clang's libFuzzer (-DTOGISHI_LIBFUZZER -fsanitize=fuzzer,address,undefined) guided by
// coverage.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "mesh_file/check_gltf.hpp"
#include "mesh_file/readers.hpp"

namespace {

using namespace togishi;

/// What Blender's importer is preceded by.
void check_as_gltf(const std::string& bytes) {
    std::istringstream in(bytes.substr(1));
    ByteSource source(in, bytes.size() - 1, "fuzzed");
    try {
        check_gltf(source, "/nonexistent", {.max_triangles = 100'000, .max_vertices = 100'000});
    } catch (const InputError&) {
        // As it should be.
    }
}

/// The first byte chooses the reader. True where a mesh came of the rest.
bool read_as(const std::string& bytes) {
    if (bytes.empty()) return false;
    std::istringstream in(bytes.substr(1));
    ByteSource source(in, bytes.size() - 1, "fuzzed");
    MeshBuilder builder("fuzzed", {.max_triangles = 100'000, .max_vertices = 100'000});
    MeshFile file;
    try {
        switch (static_cast<unsigned char>(bytes[0]) % 4) {
            case 0:
                read_ply(source, builder, file);
                break;
            case 1:
                read_obj(source, builder, file);
                break;
            case 2:
                read_stl(source, builder, file);
                break;
            // No buffers beside it: a folder that is not there.
            default:
                check_as_gltf(bytes);
                read_gltf(source, "/nonexistent", builder, file);
                break;
        }
        const TriangleMesh mesh = builder.finish();
        for (const Triangle& t : mesh.triangles) {
            for (const std::uint32_t v : t) {
                if (v >= mesh.positions.size()) std::abort();
            }
        }
        return true;
    } catch (const InputError&) {
        return false;
    }
}

#ifndef TOGISHI_LIBFUZZER

std::string gltf_seed() {
    std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"scale":[1,2,-1]}],)"
        R"("buffers":[{"byteLength":48}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":3}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}]})";
    while (json.size() % 4 != 0) json += ' ';
    const auto number = [](std::size_t value) {
        std::string out;
        for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> 8 * i & 0xffU);
        return out;
    };
    std::string binary(48, '\0');
    binary[14] = '\x80', binary[15] = '\x3f', binary[40] = '\1', binary[44] = '\2';
    return "glTF" + number(2) + number(28 + json.size() + binary.size()) + number(json.size()) +
           "JSON" + json + number(binary.size()) + std::string("BIN\0", 4) + binary;
}

std::vector<std::string> seeds() {
    const std::string vertex =
        "property float x\nproperty double y\nproperty short z\nproperty uchar red\n";
    const std::string faces =
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    std::vector<std::string> all;
    const std::string zero(1, '\0');
    all.push_back(zero + "ply\nformat ascii 1.0\nelement vertex 5\n" + vertex + faces +
                  "0 0 0 1\n1 0 0 2\n1 1 0 3\n0.5 .2 0 4\n0 1 0 5\n5 0 1 2 3 4\n");
    for (const char* order : {"little", "big"}) {
        std::string rows;
        for (int i = 0; i < 4; ++i)
            rows +=
                std::string(3, '\0') + std::string(1, static_cast<char>(i)) + std::string(11, '\0');
        const bool big = std::string(order) == "big";
        std::string face(1, '\4');
        for (const char v : {0, 1, 2, 3})
            face += big ? std::string(3, '\0') + v : v + std::string(3, '\0');
        all.push_back(zero + "ply\nformat binary_" + order + "_endian 1.0\nelement vertex 4\n" +
                      vertex + faces + rows + face);
    }
    all.push_back(zero + "ply\nformat ascii 1.0\nelement vertex 4\n" + vertex +
                  "property list uchar char extra\nelement tristrips 1\nproperty list int int "
                  "vertex_indices\nend_header\n0 0 0 1 0\n1 0 0 2 1 9\n1 1 0 3 0\n0 1 0 4 0\n6 0 1 "
                  "2 -1 3 1\n");
    all.emplace_back(
        "\1v 0 0 0 1 0 0\nv 1 0 0 # x\nv 1 1 0\nv .5 .2 0\nv 0 1 0\nvn 0 0 1\nf 1/1/1 2//1 \\\n3 4 "
        "5\nf -1 -2 -3\n");
    all.emplace_back(
        "\2solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\nendsolid x\n");
    all.push_back("\2" + std::string(80, 'x') + std::string("\2\0\0\0", 4) +
                  std::string(100, '\7'));
    all.push_back("\3" + gltf_seed());
    all.emplace_back(
        "\3{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":3,\"uri\":\"data:"
        "application/octet-stream;base64,AAAA\"}]}");
    return all;
}

class Breaker {
  public:
    explicit Breaker(std::uint64_t seed) : random_(seed) {}

    std::string broken(std::string text, const std::vector<std::string>& corpus) {
        for (std::size_t n = 1 + below(6); n > 0; --n) {
            const std::size_t at = below(text.size() + 1);
            switch (below(9)) {
                case 0:
                    text.resize(std::max<std::size_t>(1, at));
                    break;
                case 1:
                    if (at < text.size()) text[at] = static_cast<char>(below(256));
                    break;
                case 2:
                    if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
                    break;
                case 3:
                    text.insert(at, 1 + below(8), static_cast<char>(below(256)));
                    break;
                case 4:
                    text.erase(at, 1 + below(16));
                    break;
                case 5:
                    text.insert(at, word());
                    break;
                case 6: {  // a number for a number
                    const std::size_t digit = text.find_first_of("0123456789", at);
                    if (digit == std::string::npos) break;
                    const std::size_t end = text.find_first_not_of("0123456789", digit);
                    text.replace(digit, end == std::string::npos ? end : end - digit, word());
                    break;
                }
                case 7: {  // a piece of another file, or of this
                    const std::string& other = corpus[below(corpus.size())];
                    text.insert(at, other.substr(below(other.size()), below(64)));
                    break;
                }
                default: {
                    const std::size_t from = below(text.size());
                    text.insert(at, text.substr(from, below(64)));
                    break;
                }
            }
            if (text.empty()) text = "x";
            if (text.size() > 20'000) text.resize(20'000);
        }
        return text;
    }

    std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }

  private:
    std::string word() {
        static const char* const words[] = {"0",
                                            "-1",
                                            "1",
                                            "255",
                                            "256",
                                            "65536",
                                            "2147483647",
                                            "4294967295",
                                            "18446744073709551616",
                                            "1e308",
                                            "nan",
                                            "inf",
                                            "-",
                                            ".",
                                            "\\\n",
                                            "\r\n",
                                            "element ",
                                            "property list ",
                                            "vertex",
                                            "face",
                                            "end_header\n",
                                            "endloop",
                                            "facet",
                                            "f ",
                                            "v ",
                                            "/",
                                            "\"",
                                            "[",
                                            "{",
                                            "}",
                                            ",",
                                            "null",
                                            "\"byteStride\":",
                                            "\"indices\":",
                                            "\"mode\":5,",
                                            "\"sparse\":{},",
                                            "\"children\":[0],",
                                            "\"matrix\":[1],",
                                            "\"normalized\":true,",
                                            "\"COLOR_0\":0,",
                                            "5121",
                                            "5123",
                                            "\"VEC4\""};
        return words[below(std::size(words))];
    }

    std::mt19937_64 random_;
};

#endif

}  // namespace

#ifdef TOGISHI_LIBFUZZER
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    (void)read_as(std::string(reinterpret_cast<const char*>(data), size));
    return 0;
}
#else
int main(int argc, char** argv) {
    const double seconds = argc > 1 ? std::strtod(argv[1], nullptr) : 10;
    Breaker breaker(argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1);
    const std::vector<std::string> whole = seeds();
    std::size_t broken_seeds = 0;
    for (std::size_t i = 0; i + 1 < whole.size(); ++i) broken_seeds += read_as(whole[i]) ? 0 : 1;
    if (broken_seeds > 0) {
        std::fprintf(stderr, "%zu of the seeds are no meshes\n", broken_seeds);
        return 1;
    }
    // Files that still read are broken further.
    std::vector<std::string> corpus = whole;
    std::uint64_t runs = 0, meshes = 0;
    const auto begin = std::chrono::steady_clock::now();
    const auto spent = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    double slowest = 0;
    while (spent() < seconds) {
        const std::string text = breaker.broken(corpus[breaker.below(corpus.size())], corpus);
        const double before = spent();
        const bool mesh = read_as(text);
        slowest = std::max(slowest, spent() - before);
        ++runs;
        if (!mesh) continue;
        ++meshes;
        if (corpus.size() < 4000) {
            corpus.push_back(text);
        } else {
            corpus[whole.size() + breaker.below(corpus.size() - whole.size())] = text;
        }
    }
    std::printf("{\"runs\": %llu, \"meshes\": %llu, \"seconds\": %.1f, \"slowest_s\": %.3f}\n",
                static_cast<unsigned long long>(runs), static_cast<unsigned long long>(meshes),
                spent(), slowest);
    return 0;
}
#endif
