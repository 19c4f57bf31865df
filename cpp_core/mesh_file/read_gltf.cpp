#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <tiny_gltf.h>
#include <glm/gtc/quaternion.hpp>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/gltf_promises.hpp"
#include "mesh_file/readers.hpp"

namespace togishi {
namespace {

using tinygltf::Accessor;
using tinygltf::Model;

/// Values of an accessor, known to lie within its buffer.
class Values {
  public:
    Values(const Model& model, int index, const std::string& where, const char* what) {
        const auto refuse = [&](const std::string& found, const std::string& allowed) {
            throw InputError(where, what, found, allowed);
        };
        if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size())
            refuse("accessor " + std::to_string(index), "an accessor that is there");
        const Accessor& a = model.accessors[static_cast<std::size_t>(index)];
        if (a.sparse.isSparse || a.bufferView < 0 ||
            static_cast<std::size_t>(a.bufferView) >= model.bufferViews.size())
            refuse("accessor " + std::to_string(index) + " without a buffer of its own",
                   "a buffer view; sparse accessors are not read");
        const auto& view = model.bufferViews[static_cast<std::size_t>(a.bufferView)];
        if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= model.buffers.size())
            refuse("buffer " + std::to_string(view.buffer), "a buffer that is there");
        const auto& data = model.buffers[static_cast<std::size_t>(view.buffer)].data;
        const int size =
            tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(a.componentType));
        const int parts = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
        if (size <= 0 || parts <= 0 || parts > 4) refuse("of unknown type", "glTF's own types");
        parts_ = static_cast<std::size_t>(parts);
        component_ = a.componentType;
        normalised_ = a.normalized;
        count_ = a.count;
        const std::size_t row = static_cast<std::size_t>(size) * parts_;
        stride_ = view.byteStride == 0 ? row : view.byteStride;
        // In steps, so that nothing overflows.
        const bool inside =
            view.byteOffset <= data.size() && view.byteLength <= data.size() - view.byteOffset &&
            a.byteOffset <= view.byteLength && stride_ >= row && stride_ <= 4096 &&
            (count_ == 0 || (row <= view.byteLength - a.byteOffset &&
                             (count_ - 1) <= (view.byteLength - a.byteOffset - row) / stride_));
        if (!inside) {
            refuse(std::to_string(a.count) + " values",
                   "no more than its buffer view holds, and a view within its buffer");
        }
        first_ = data.data() + view.byteOffset + a.byteOffset;
    }

    [[nodiscard]] std::size_t count() const { return count_; }
    [[nodiscard]] std::size_t parts() const { return parts_; }
    [[nodiscard]] int component() const { return component_; }

    /// Integers that stand for fractions as fractions.
    [[nodiscard]] double at(std::size_t row, std::size_t part) const {
        const unsigned char* const from = first_ + row * stride_;
        switch (component_) {
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                return fraction<std::int8_t>(from, part, 127);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return fraction<std::uint8_t>(from, part, 255);
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                return fraction<std::int16_t>(from, part, 32767);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return fraction<std::uint16_t>(from, part, 65535);
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                return load<std::uint32_t>(from, part);
            case TINYGLTF_COMPONENT_TYPE_FLOAT:
                return load<float>(from, part);
            default:
                return 0;
        }
    }

  private:
    template <class T>
    static T load(const unsigned char* from, std::size_t part) {
        T value;
        std::memcpy(&value, from + part * sizeof(T), sizeof(T));
        return value;
    }
    template <class T>
    [[nodiscard]] double fraction(const unsigned char* from, std::size_t part, double most) const {
        const double value = load<T>(from, part);
        return normalised_ ? std::max(value / most, -1.0) : value;
    }

    const unsigned char* first_ = nullptr;
    std::size_t count_ = 0, parts_ = 0, stride_ = 0;
    int component_ = 0;
    bool normalised_ = false;
};

std::uint8_t byte_of(double fraction) {
    // A NaN is 0.
    return fraction >= 1  ? 255
           : fraction > 0 ? static_cast<std::uint8_t>(std::lround(255 * fraction))
                          : 0;
}

/// glTF's vertex colours are linear.
std::uint8_t display(double c) {
    return byte_of(c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
}

glm::dmat4 placing(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {
        glm::dmat4 m;
        for (std::size_t i = 0; i < 16; ++i)
            m[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = node.matrix[i];
        return m;
    }
    glm::dmat4 m(1);
    if (node.rotation.size() == 4) {
        m = glm::mat4_cast(
            glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
    }
    if (node.scale.size() == 3) {
        for (int i = 0; i < 3; ++i) m[i] *= node.scale[static_cast<std::size_t>(i)];
    }
    if (node.translation.size() == 3)
        m[3] = {node.translation[0], node.translation[1], node.translation[2], 1};
    return m;
}

class Scene {
  public:
    Scene(const Model& model, const std::string& where, MeshBuilder& builder, MeshFile& file)
        : model_(model),
          where_(where),
          builder_(builder),
          file_(file),
          reached_(model.nodes.size(), 0) {}

    void read() {
        const int scene = model_.defaultScene >= 0 ? model_.defaultScene : 0;
        if (static_cast<std::size_t>(scene) < model_.scenes.size()) {
            walk(model_.scenes[static_cast<std::size_t>(scene)].nodes);
        } else {
            for (const auto& mesh : model_.meshes) add(mesh, glm::dmat4(1));
        }
        if (others_) file_.notes.emplace_back("It holds points or lines too; they are not read.");
    }

  private:
    /// Without recursion: a file may chain a million nodes.
    void walk(const std::vector<int>& roots) {
        std::vector<std::pair<int, glm::dmat4>> waiting;
        waiting.reserve(roots.size());
        for (const int root : roots) waiting.emplace_back(root, glm::dmat4(1));
        while (!waiting.empty()) {
            const auto [index, above] = waiting.back();
            waiting.pop_back();
            const auto at = static_cast<std::size_t>(index);
            if (index < 0 || at >= model_.nodes.size())
                throw InputError(where_, "node", std::to_string(index), "a node that is there");
            if (reached_[at]++ != 0)
                throw InputError(where_, "node " + std::to_string(index), "reached twice",
                                 "nodes that form a tree");
            const auto& node = model_.nodes[at];
            const glm::dmat4 here = above * placing(node);
            if (node.mesh >= 0 && static_cast<std::size_t>(node.mesh) < model_.meshes.size())
                add(model_.meshes[static_cast<std::size_t>(node.mesh)], here);
            for (const int child : node.children) waiting.emplace_back(child, here);
        }
    }

    void add(const tinygltf::Mesh& mesh, const glm::dmat4& to_scene) {
        for (const auto& primitive : mesh.primitives) {
            const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
            if (mode < TINYGLTF_MODE_TRIANGLES) {
                others_ = true;
                continue;
            }
            add(primitive, mode, to_scene);
        }
    }

    void add(const tinygltf::Primitive& primitive, int mode, const glm::dmat4& to_scene) {
        const auto position = primitive.attributes.find("POSITION");
        if (position == primitive.attributes.end()) {
            throw InputError(where_, "POSITION", "missing", "a primitive's attribute");
        }
        const Values points(model_, position->second, where_, "POSITION");
        if (points.parts() != 3)
            throw InputError(where_, "POSITION", std::to_string(points.parts()) + " components",
                             "3");
        const std::uint64_t first = builder_.vertices();
        for (std::size_t i = 0; i < points.count(); ++i) {
            const glm::dvec4 p(points.at(i, 0), points.at(i, 1), points.at(i, 2), 1);
            builder_.vertex(glm::dvec3(to_scene * p));
        }
        add_colours(primitive, points.count(), first);
        const bool mirrored = glm::determinant(glm::dmat3(to_scene)) < 0;
        const auto triangle = [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
            if (mirrored) std::swap(b, c);
            builder_.triangle(static_cast<std::uint32_t>(first + a),
                              static_cast<std::uint32_t>(first + b),
                              static_cast<std::uint32_t>(first + c));
        };
        if (primitive.indices < 0) {
            connect(
                mode, points.count(), [](std::uint64_t i) { return i; }, triangle);
            return;
        }
        const Values indices(model_, primitive.indices, where_, "indices");
        if (indices.parts() != 1 || indices.component() == TINYGLTF_COMPONENT_TYPE_FLOAT)
            throw InputError(where_, "indices", "no whole numbers", "unsigned integers");
        const auto index = [&](std::uint64_t i) {
            const double v = indices.at(i, 0);
            if (!(v >= 0 && v < static_cast<double>(points.count()))) {
                throw InputError(where_, "vertex index", std::to_string(v),
                                 "0 to " + std::to_string(points.count()) + " - 1, counted from 0");
            }
            return static_cast<std::uint64_t>(v);
        };
        connect(mode, indices.count(), index, triangle);
    }

    template <class Index, class Add>
    static void connect(int mode, std::uint64_t count, const Index& index, const Add& triangle) {
        if (mode == TINYGLTF_MODE_TRIANGLES) {
            for (std::uint64_t i = 0; i + 2 < count; i += 3)
                triangle(index(i), index(i + 1), index(i + 2));
            return;
        }
        const bool fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
        for (std::uint64_t i = 0; i + 2 < count; ++i) {
            const bool turned = !fan && i % 2 == 1;
            triangle(index(fan ? 0 : i), index(turned ? i + 2 : i + 1),
                     index(turned ? i + 1 : i + 2));
        }
    }

    void add_colours(const tinygltf::Primitive& primitive, std::size_t count, std::uint64_t first) {
        const auto found = primitive.attributes.find("COLOR_0");
        if (found == primitive.attributes.end()) return;
        const Values colours(model_, found->second, where_, "COLOR_0");
        if (colours.count() != count || colours.parts() < 3)
            throw InputError(where_, "COLOR_0", std::to_string(colours.count()) + " values",
                             "RGB or RGBA for each vertex");
        for (std::size_t i = 0; i < count; ++i) {
            Colour8 c{0, 0, 0, 255};
            for (std::size_t k = 0; k < 3; ++k) c[k] = display(colours.at(i, k));
            if (colours.parts() == 4) c[3] = byte_of(colours.at(i, 3));
            builder_.colour_of(first + i, c);
        }
    }

    const Model& model_;
    const std::string& where_;
    MeshBuilder& builder_;
    MeshFile& file_;
    std::vector<std::uint8_t> reached_;
    bool others_ = false;
};

/// tinygltf gets our buffers, by their numbers, and no file.
tinygltf::FsCallbacks from_memory(GltfParts& parts) {
    tinygltf::FsCallbacks calls{};
    calls.FileExists = [](const std::string&, void*) { return true; };
    calls.ExpandFilePath = [](const std::string& name, void*) { return name; };
    calls.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& name,
                             void* user) {
        auto& buffers = static_cast<GltfParts*>(user)->buffers;
        const auto number = parse_number(std::filesystem::path(name).filename().string());
        if (!number || *number < 0 || *number >= static_cast<double>(buffers.size())) return false;
        *out = std::move(buffers[static_cast<std::size_t>(*number)]);
        return true;
    };
    calls.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&,
                              void*) { return false; };
    calls.user_data = &parts;
    return calls;
}

}  // namespace

void read_gltf(ByteSource& source, const std::filesystem::path& folder, MeshBuilder& builder,
               MeshFile& file) {
    GltfParts parts = read_gltf_parts(source, folder, file);
    Model model;
    tinygltf::TinyGLTF library;
    library.SetFsCallbacks(from_memory(parts));
    std::string error, warning;
    bool good = false;
    try {
        good = library.LoadASCIIFromString(&model, &error, &warning, parts.json.c_str(),
                                           static_cast<unsigned>(parts.json.size()), "");
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {
        error = e.what();
    }
    if (!good) {
        std::replace(error.begin(), error.end(), '\n', ' ');
        throw InputError(source.where(), "glTF", "refused by tinygltf: " + error,
                         "glTF 2.0 as its specification has it");
    }
    parts = {};
    file.unit = "m";
    Scene(model, source.where(), builder, file).read();
}

}  // namespace togishi
