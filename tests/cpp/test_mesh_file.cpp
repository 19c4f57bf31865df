#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "mesh_file/read_mesh.hpp"
#include "mesh_file/write_ply.hpp"
#include "mesh_shapes.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

class MeshFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() /
                  ("togishi_mesh_" +
                   std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    fs::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    MeshFile read(const std::string& name, const std::string& bytes) const {
        return read_mesh(write(name, bytes));
    }
    /// The sentence with which a file is refused, at once.
    std::string refusal(const std::string& name, const std::string& bytes,
                        const MeshLimits& limits = {}) const {
        const auto begin = std::chrono::steady_clock::now();
        std::string text = "it was read";
        try {
            (void)read_mesh(write(name, bytes), limits);
        } catch (const InputError& error) {
            text = error.what();
            EXPECT_NE(text.find(name), std::string::npos) << text;
        }
        EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
        return text;
    }

    fs::path folder_;
};

void expect_refusal(const std::string& text, std::initializer_list<const char*> pieces) {
    for (const char* piece : pieces) EXPECT_NE(text.find(piece), std::string::npos) << text;
}

template <class T>
std::string bytes_of(T value, bool big = false) {
    std::string out(sizeof(T), '\0');
    std::memcpy(out.data(), &value, sizeof(T));
    if (big) std::reverse(out.begin(), out.end());
    return out;
}

std::vector<glm::dvec3> corners_of(const TriangleMesh& mesh) {
    std::vector<glm::dvec3> out;
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) out.push_back(mesh.origin + glm::dvec3(mesh.positions[v]));
    }
    return out;
}

void expect_same(const TriangleMesh& a, const TriangleMesh& b, double within) {
    const auto p = corners_of(a), q = corners_of(b);
    ASSERT_EQ(p.size(), q.size());
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_LE(glm::length(p[i] - q[i]), within);
}

TEST_F(MeshFiles, PlyKeepsFarOffCoordinatesAndColours) {
    TriangleMesh mesh = shapes::ball(0.5, 4);
    mesh.origin = {100000, -200000.5, 3};
    mesh.colours.resize(mesh.positions.size(), Colour8{1, 2, 3, 4});
    write_ply(folder_ / "a.ply", mesh, "made by\na test");
    const MeshFile file = read_mesh(folder_ / "a.ply");
    EXPECT_EQ(file.format, "PLY, binary little-endian");
    expect_same(file.mesh, mesh, 1e-7);  // a float would have steps of 0.008 there
    EXPECT_EQ(file.mesh.colours, mesh.colours);
    write_ply(folder_ / "b.ply", mesh, {}, true);
    expect_same(read_mesh(folder_ / "b.ply").mesh, mesh, 0.02);
}

TEST_F(MeshFiles, AnyPathOpens) {
    const TriangleMesh mesh = shapes::cube(1);
    const fs::path path = folder_ / "太刀 \"大包平\" it's.ply";
    write_ply(path, mesh);
    expect_same(read_mesh(path).mesh, mesh, 1e-6);
    expect_refusal(refusal("刀 'x'.ply", "ply\nnonsense\n"), {"刀 'x'.ply", "line 2"});
}

/// A cube's six squares, with what scanners put beside.
std::string ply_of_squares(const std::string& format) {
    const bool text = format == "ascii", big = format == "binary_big_endian";
    std::string out =
        "ply\r\nformat " + format +
        " 1.0\r\ncomment none\r\nobj_info x\r\nelement vertex 8\r\nproperty float nx\r\n"
        "property double x\r\nproperty int y\r\nproperty float z\r\n"
        "property uchar red\r\nproperty float green\r\nproperty ushort blue\r\n"
        "property list uchar short extra\r\nelement camera 1\r\nproperty short id\r\n"
        "element face 6\r\nproperty uchar flags\r\n"
        "property list uchar int vertex_indices\r\nproperty list int float texcoord\r\n"
        "end_header\r\n";
    const auto add = [&](auto value) {
        out += text ? std::to_string(value) + (value == 0 ? "\n" : " ") : bytes_of(value, big);
    };
    for (int i = 0; i < 8; ++i) {
        add(0.5F);
        add(static_cast<double>(i & 1));
        add(static_cast<std::int32_t>(i >> 1 & 1));
        add(static_cast<float>(i >> 2));
        add(static_cast<std::uint8_t>(200));
        add(1.0F);
        add(static_cast<std::uint16_t>(257));
        add(static_cast<std::uint8_t>(2));
        add(static_cast<std::int16_t>(-7));
        add(static_cast<std::int16_t>(8));
    }
    add(static_cast<std::int16_t>(3));
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& face : faces) {
        add(static_cast<std::uint8_t>(9));
        add(static_cast<std::uint8_t>(4));
        for (const int v : face) add(static_cast<std::int32_t>(v));
        add(static_cast<std::int32_t>(1));
        add(0.25F);
    }
    return out;
}

TEST_F(MeshFiles, PlyOfEveryKind) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const MeshFile file = read("squares.ply", ply_of_squares(format));
        EXPECT_EQ(file.polygons, 6U) << format;
        ASSERT_EQ(file.mesh.triangles.size(), 12U);
        EXPECT_NEAR(shapes::volume(file.mesh), 1, 1e-6);
        ASSERT_EQ(file.mesh.colours.size(), 8U);
        EXPECT_EQ(file.mesh.colours[3], (Colour8{200, 255, 1, 255}));
        const std::string whole = ply_of_squares(format);
        expect_refusal(refusal("cut.ply", whole.substr(0, whole.size() - 30)), {"cut off"});
    }
}

TEST_F(MeshFiles, PlyStrips) {
    const MeshFile file = read(
        "strip.ply",
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
        "float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 2 3 4 -1\n");
    ASSERT_EQ(file.mesh.triangles.size(), 3U);
    EXPECT_EQ(file.mesh.triangles[1], (Triangle{2, 1, 3}));
}

TEST_F(MeshFiles, PlyThatLies) {
    const std::string head = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    const std::string xyz = "\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string face = "element face ";
    const std::string list = "\nproperty list uchar int vertex_indices\nend_header\n";
    expect_refusal(
        refusal("a.ply", head + "3" + xyz + face + "1000000000000" + list + std::string(100, '\0')),
        {"element \"face\"", "1000000000000 rows", "at most 4", "cut off"});
    expect_refusal(refusal("a.ply", head + "99999999999999999999" + xyz + face + "1" + list),
                   {"line 3", "count", "whole number"});
    const std::string points = bytes_of(0.0F) + bytes_of(0.0F) + bytes_of(0.0F);
    const auto triangle = [](std::int32_t a) {
        return "\3" + bytes_of(a) + bytes_of(std::int32_t{1}) + bytes_of(std::int32_t{2});
    };
    expect_refusal(refusal("a.ply", head + "3" + xyz + face + "1" + list + points + points +
                                        points + triangle(3)),
                   {"face 1", "vertex index is 3", "0 to 3 - 1"});
    expect_refusal(refusal("a.ply", head + "3" + xyz + face + "1" + list + points + points +
                                        points + triangle(-1)),
                   {"face 1", "vertex index is -1"});
    const std::string nan = bytes_of(1.0F) + bytes_of(std::nanf("")) + bytes_of(0.0F);
    expect_refusal(refusal("a.ply", head + "3" + xyz + face + "1" + list + points + nan + points +
                                        triangle(0)),
                   {"vertex 2", "y is nan"});
    expect_refusal(refusal("a.ply", head + "3" + xyz + "end_header\n" + points + points + points),
                   {"triangles is 0", "cloud of points"});
    expect_refusal(refusal("a.ply", head + "1\nproperty float x\nend_header\nabcd"),
                   {"element vertex with x, y and z"});
    expect_refusal(refusal("a.ply", head + "1" + xyz), {"header is cut off"});
    expect_refusal(refusal("a.ply", head + "1\nproperty quaternion x\n"), {"line 4", "quaternion"});
    expect_refusal(refusal("a.ply", "ply\nformat ascii 1.0\nelement vertex 1" + xyz + face + "1" +
                                        list + "0 0 zero\n3 0 0 0\n"),
                   {"line 10", "\"zero\""});
    expect_refusal(refusal("a.ply", ply_of_squares("ascii"), {.max_triangles = 4}),
                   {"more than 4", "can be raised"});
    // Rows of nothing cost nothing, however many.
    expect_refusal(
        refusal("a.ply", head + "0" + xyz + "element nothing 1000000000000\nend_header\n"),
        {"triangles is 0"});
}

TEST_F(MeshFiles, Obj) {
    const MeshFile file = read("a.obj",
                               "# made by hand\r\nmtllib none.mtl\nv 100000.001 0 0 1 0 0\n"
                               "v 100001.001 0 0 0 1 0\nv 100001.001 1 0 0 0 1 # corner\n"
                               "v 100000.001 1 0 .5 .5 .5\nvt 0 0\nvn 0 0 1\no name\n"
                               "f 1/1/1 2//1 \\\n 3 4\nl 1 2\nf -4 -3 -2\n");
    EXPECT_EQ(file.format, "OBJ");
    ASSERT_EQ(file.mesh.triangles.size(), 3U);
    EXPECT_EQ(file.polygons, 1U);
    EXPECT_NEAR(corners_of(file.mesh)[0].x, 100000.001, 1e-6);
    EXPECT_EQ(file.mesh.colours[1], (Colour8{0, 255, 0, 255}));
    expect_refusal(refusal("a.obj", "v 0 0 0\nv 1 x 0\n"), {"line 2", "\"x\""});
    expect_refusal(refusal("a.obj", "v 0 0\n"), {"line 1", "2 numbers"});
    expect_refusal(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n"),
                   {"triangle 1", "vertex index is 8", "0 to 3 - 1"});
    expect_refusal(refusal("a.obj", "v 0 0 0\nf 1 2 -2\n"), {"line 2", "\"-2\""});
    expect_refusal(refusal("a.obj", "v 0 0 0\nf 1 0 1\n"), {"line 2", "\"0\""});
    expect_refusal(refusal("a.obj", "v 0 0 0\nf 1 1\n"), {"line 2", "corners is 2"});
    expect_refusal(refusal("a.obj", std::string(5000, 'v')), {"line 1", "200 characters"});
    expect_refusal(refusal("a.obj", ""), {"triangles is 0"});
}

TEST_F(MeshFiles, PolygonsAreCutWithoutFolds) {
    // An arrow, whose fan from its first corner would lie outside.
    const MeshFile file = read("a.obj",
                               "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nf 5 1 2 3 4\n"
                               "v 0 0 1\nv 1 1 1\nv 2 0 1\nv 1 3 1\nf 6 7 8 9\n");
    double area = 0, turned = 0;
    for (const Triangle& t : file.mesh.triangles) {
        const auto at = [&](std::size_t k) { return glm::dvec3(file.mesh.positions[t[k]]); };
        const double z = glm::cross(at(1) - at(0), at(2) - at(0)).z / 2;
        area += std::abs(z);
        turned += z;
    }
    EXPECT_NEAR(area, 2.5 + 2, 1e-6);
    EXPECT_NEAR(std::abs(turned), area, 1e-6);
}

TEST_F(MeshFiles, Stl) {
    const TriangleMesh cube = shapes::cube(2, {1e5, 0, 0});
    std::string text = "solid a name\n", rows;
    for (const Triangle& t : cube.triangles) {
        text += " facet normal 0 0 nan\n  outer loop\n";
        rows += std::string(12, '\0');
        for (const std::uint32_t v : t) {
            text += "   vertex";
            for (int i = 0; i < 3; ++i) {
                text += " " + std::to_string(cube.positions[v][i]);
                rows += bytes_of(cube.positions[v][i]);
            }
            text += "\n";
        }
        text += "  endloop\n endfacet\n";
        rows += std::string(2, '\0');
    }
    const MeshFile ascii = read("a.stl", text + "endsolid a name\n");
    EXPECT_EQ(ascii.mesh.positions.size(), 8U);
    expect_same(ascii.mesh, cube, 1e-6);
    // Exporters begin binary files with "solid" too.
    const std::string head = "solid" + std::string(75, ' ') + bytes_of(std::uint32_t{12});
    const MeshFile binary = read("b.stl", head + rows);
    EXPECT_EQ(binary.format, "STL, binary");
    EXPECT_EQ(binary.mesh.positions.size(), 8U);
    expect_same(binary.mesh, cube, 1e-6);

    expect_refusal(refusal("a.stl", text.substr(0, text.size() / 2)), {"line"});
    expect_refusal(
        refusal("a.stl", std::string(80, 'x') + bytes_of(std::uint32_t{12}) + rows.substr(0, 400)),
        {"size is 484 bytes", "12 triangles"});
    expect_refusal(refusal("a.stl", std::string(80, 'x') + bytes_of(0xffffffffU) + rows),
                   {"4294967295 triangles"});
    expect_refusal(refusal("a.stl", "xyz"), {"84 bytes at least"});
}

// --- glTF
// ------------------------------------------------------------------------------------------

std::string glb(std::string json, std::string binary) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    const auto length = static_cast<std::uint32_t>(28 + json.size() + binary.size());
    return "glTF" + bytes_of(std::uint32_t{2}) + bytes_of(length) +
           bytes_of(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
           bytes_of(static_cast<std::uint32_t>(binary.size())) + std::string("BIN\0", 4) + binary;
}

struct Gltf {
    std::string buffer = R"({"byteLength": 84})";
    std::string views =
        R"({"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}, {"buffer": 0, "byteOffset": 48, "byteLength": 36})";
    std::string count = "3";
    std::string indices = R"(, "indices": 1)";
    std::string nodes =
        R"({"children": [1]}, {"mesh": 0, "translation": [10, 0, 0], "scale": [2, 2, -2]})";
    std::string more;

    [[nodiscard]] std::string json() const {
        return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [)" +
               nodes + R"(], "buffers": [)" + buffer + R"(], "bufferViews": [)" + views +
               R"(], "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": )" +
               count +
               R"(}, {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3}, {"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 3}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 2})" +
               indices + "}]}]" + more + "}";
    }
    static std::string binary(std::uint32_t last = 2) {
        std::string out;
        for (const float v : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) out += bytes_of(v);
        for (const std::uint32_t i : {0U, 1U, last}) out += bytes_of(i);
        for (const float v : {0.F, 0.F, 0.F, 1.F, .5F, 0.F, 0.F, 1.F, 0.F}) out += bytes_of(v);
        return out;
    }
};

TEST_F(MeshFiles, GltfPlacedByItsNodes) {
    const Gltf gltf;
    const MeshFile file = read("a.glb", glb(gltf.json(), Gltf::binary()));
    EXPECT_EQ(file.format, "GLB");
    EXPECT_EQ(file.unit, "m");
    ASSERT_EQ(file.mesh.triangles.size(), 1U);
    EXPECT_EQ(file.mesh.triangles[0], (Triangle{0, 2, 1}));  // mirrored by its scale
    EXPECT_NEAR(corners_of(file.mesh)[2].x, 12, 1e-6);
    EXPECT_EQ(file.mesh.colours[1], (Colour8{255, 188, 0, 255}));

    Gltf beside = gltf;
    beside.buffer = R"({"byteLength": 84, "uri": "my%20points.bin"})";
    write("my points.bin", Gltf::binary());
    const MeshFile text = read("a.gltf", beside.json());
    EXPECT_EQ(text.format, "glTF");
    EXPECT_EQ(corners_of(text.mesh), corners_of(file.mesh));
}

TEST_F(MeshFiles, GltfThatLies) {
    const std::string binary = Gltf::binary();
    const auto with = [&](auto Gltf::*part, const std::string& text) {
        Gltf gltf;
        gltf.*part = text;
        return refusal("a.glb", glb(gltf.json(), binary));
    };
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": 1000000000000})"),
                   {"buffer 0", "byteLength is 1000000000000", "84 bytes"});
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": 84}, {"byteLength": 84})"),
                   {"buffer 1", "each file once"});
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": -5})"), {"byteLength is", "-5"});
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": 84, "uri": "../a.bin"})"),
                   {"uri", "in the folder of the glTF file"});
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": 84, "uri": "/etc/passwd"})"),
                   {"uri", "in the folder of the glTF file"});
    expect_refusal(with(&Gltf::buffer, R"({"byteLength": 84, "uri": "none.bin"})"),
                   {"uri", "which is missing"});
    expect_refusal(
        with(&Gltf::buffer,
             R"({"byteLength": 84, "uri": "data:application/octet-stream;base64,AAAA"})"),
        {"byteLength is 84", "data: URI"});
    expect_refusal(with(&Gltf::count, "1000000000000"), {"POSITION is 1000000000000 values"});
    expect_refusal(with(&Gltf::nodes, R"({"children": [0]})"), {"node 0", "reached twice"});
    expect_refusal(with(&Gltf::nodes, R"({"children": [7]})"), {"node is 7"});
    expect_refusal(with(&Gltf::indices, R"(, "indices": 9)"), {"a.glb"});
    expect_refusal(with(&Gltf::more, R"(, "extensionsRequired": ["KHR_draco_mesh_compression"])"),
                   {"extensionsRequired", "KHR_draco", "without compression"});
    expect_refusal(with(&Gltf::more, R"(, "x": )" + std::string(100, '[') + std::string(100, ']')),
                   {"nested deeper than 64"});
    expect_refusal(refusal("a.glb", glb(Gltf().json(), Gltf::binary(3))), {"vertex index is 3"});
    const std::string whole = glb(Gltf().json(), binary);
    expect_refusal(refusal("a.glb", whole.substr(0, whole.size() - 40)), {"cut off"});
    expect_refusal(refusal("a.glb", whole.substr(0, 15)), {"cut off"});
    expect_refusal(refusal("a.gltf", "{\"asset\": "), {"not well formed"});
}

TEST_F(MeshFiles, NoMeshAtAll) {
    expect_refusal(refusal("a.xyz", "1 2 3\n"), {"format", "PLY, OBJ, STL, glTF or GLB"});
    expect_refusal(refusal("b.ply", ""), {"an empty file"});
    EXPECT_THROW((void)read_mesh(folder_), InputError);
    EXPECT_THROW((void)read_mesh(folder_ / "none.ply"), InputError);
}

}  // namespace
}  // namespace togishi
