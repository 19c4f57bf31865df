// scanned/import.hpp
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "mesh_file/check_gltf.hpp"
#include "mesh_file/read_own_mesh.hpp"
#include "python/blade_mesh_views.hpp"
#include "python/blade_parameters.hpp"
#include "python/module.hpp"
#include "scanned/import.hpp"

namespace py = pybind11;

namespace togishi {
namespace {

constexpr const char* where = "scan";

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename T>
void need_shape(const Array<T>& array, const char* field, py::ssize_t columns) {
    if (array.ndim() != 2 || array.shape(1) != columns) {
        throw InputError(where, field, py::cast<std::string>(py::str(array.attr("shape"))),
                         "(N, " + std::to_string(columns) + ")");
    }
}

TriangleMesh mesh_from(const Array<float>& positions, const Array<std::int32_t>& triangles,
                       const py::object& colours, const std::array<double, 3>& origin) {
    need_shape(positions, "positions", 3);
    need_shape(triangles, "triangles", 3);
    TriangleMesh mesh;
    mesh.origin = {origin[0], origin[1], origin[2]};
    const auto count = static_cast<std::size_t>(positions.shape(0));
    mesh.positions.resize(count);
    std::memcpy(mesh.positions.data(), positions.data(), count * sizeof(glm::vec3));
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 p = mesh.positions[i];
        if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
            throw InputError(where, "vertex " + std::to_string(i), "not finite",
                             "finite coordinates");
        }
    }
    mesh.triangles.resize(static_cast<std::size_t>(triangles.shape(0)));
    const std::int32_t* index = triangles.data();
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t v = index[3 * f + k];
            if (v < 0 || static_cast<std::size_t>(v) >= count) {
                throw InputError(where, "triangle " + std::to_string(f), std::to_string(v),
                                 "0 to " + std::to_string(count) + " - 1");
            }
            mesh.triangles[f][k] = static_cast<std::uint32_t>(v);
        }
    }
    if (!colours.is_none()) {
        const Array<std::uint8_t> values(colours);
        need_shape(values, "colours", 4);
        if (static_cast<std::size_t>(values.shape(0)) != count)
            throw InputError(where, "colours", std::to_string(values.shape(0)),
                             "one a vertex: " + std::to_string(count));
        mesh.colours.resize(count);
        std::memcpy(mesh.colours.data(), values.data(), count * sizeof(Colour8));
    }
    return mesh;
}

ImportOptions options_from(const py::dict& values, const py::object& painted) {
    ImportOptions o;
    for (const auto& [key, value] : values) {
        const auto name = py::cast<std::string>(py::str(key));
        const auto number = [&, &v = value] { return py::cast<double>(v); };
        const auto count = [&](double least, double most) {
            const double n = number();
            if (!(n >= least && n <= most))
                throw InputError("options", name, std::to_string(n),
                                 whole_number(least) + " to " + whole_number(most));
            return static_cast<std::size_t>(n);
        };
        if (name == "mm_per_unit") {
            o.mm_per_unit = number();
        } else if (name == "error_mm") {
            o.prepare.error_mm = number();
        } else if (name == "close_holes_mm") {
            o.close_holes_mm = number();
        } else if (name == "texture_px") {
            o.prepare.detail.width = count(256, 32768);
        } else if (name == "levels") {
            o.prepare.levels = count(1, 6);
        } else if (name == "replicates") {
            o.analysis.replicates = static_cast<int>(count(0, 1000));
        } else if (name == "swap_ends") {
            o.analysis.correction.swap_ends = py::cast<bool>(value);
        } else if (name == "swap_edge_and_back") {
            o.analysis.correction.swap_edge_and_back = py::cast<bool>(value);
        } else if (name == "kissaki_mm") {
            o.analysis.correction.kissaki_mm = number();
        } else if (name == "machi") {
            const auto at = py::cast<std::array<double, 3>>(value);
            o.machi = glm::dvec3(at[0], at[1], at[2]);
        } else {
            throw InputError(
                "options", "key", name,
                "mm_per_unit, error_mm, close_holes_mm, texture_px, levels, replicates, "
                "swap_ends, swap_edge_and_back, machi, kissaki_mm");
        }
    }
    if (!painted.is_none()) {
        const auto given = py::cast<py::dict>(painted);
        o.painted.mesh = mesh_from(py::cast<Array<float>>(given["positions_mm"]),
                                   py::cast<Array<std::int32_t>>(given["triangles"]), py::none(),
                                   py::cast<std::array<double, 3>>(given["origin_mm"]));
        o.painted.part = py::cast<std::vector<std::int32_t>>(given["part"]);
    }
    return o;
}

const BladeMesh& finest(const py::object& self) {
    const auto& scan = self.cast<const ImportedScan&>();
    if (scan.blade.levels.empty())
        throw InputError(where, "blade", "none", "a scan that is told to be a blade");
    return scan.blade.levels.front().mesh;
}

std::vector<std::array<double, 3>> points_of(const std::vector<glm::dvec3>& points) {
    std::vector<std::array<double, 3>> all;
    all.reserve(points.size());
    for (const glm::dvec3& p : points) all.push_back({p.x, p.y, p.z});
    return all;
}

py::dict report_of(const ImportedScan& scan) {
    py::dict report;
    const ScanAnalysis& found = scan.analysis;
    report["verdict"] = py::dict(py::arg("is_blade") = scan.is_blade(),
                                 py::arg("kind") = std::string(verdict_name(found.verdict)),
                                 py::arg("text") = found.text);
    report["unit"] =
        py::dict(py::arg("mm_per_unit") = scan.mm_per_unit, py::arg("text") = scan.unit_text);
    const auto drawn = drawn_measures(found.stations);
    py::list dimensions;
    for (const ScanMeasure& m : found.measures) {
        py::dict d;
        d["key"] = m.name;
        d["label"] = measure_label(m.name);
        d["value"] = m.value;
        d["sigma"] = m.sigma;
        d["unit"] = m.unit;
        d["inferred"] = m.inferred;
        d["note"] = m.note;
        const auto line = drawn.find(m.name);
        d["points_mm"] = line == drawn.end() ? points_of({}) : points_of(line->second);
        dimensions.append(d);
    }
    report["dimensions"] = dimensions;
    report["mune"] = found.mune_type;
    report["zukuri"] = found.zukuri;
    report["notes"] = found.doubts;
    report["inferred"] = scan.inferred;
    const BladePose& pose = scan.analysis.pose;
    py::list rows;
    for (int r = 0; r < 3; ++r) {
        rows.append(py::make_tuple(pose.rotation[0][r], pose.rotation[1][r], pose.rotation[2][r]));
    }
    report["pose"] = py::dict(py::arg("rotation") = rows,
                              py::arg("origin_mm") = py::make_tuple(
                                  pose.origin_mm.x, pose.origin_mm.y, pose.origin_mm.z));
    py::dict seconds;
    for (const auto& [step, time] : scan.time) seconds[py::str(step)] = time.seconds;
    report["seconds"] = seconds;
    return report;
}

py::dict maps_of(const py::object& self) {
    const auto& scan = self.cast<const ImportedScan&>();
    const DetailMaps& detail = scan.blade.detail;
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(detail.height),
                                         static_cast<py::ssize_t>(detail.width)};
    py::dict maps;
    if (!detail.normal.empty()) maps["normal"] = view<float>(self, detail.normal, shape);
    if (!detail.displacement_mm.empty())
        maps["displacement_mm"] = view<float>(self, detail.displacement_mm, shape);
    if (!detail.colour.empty()) maps["colour"] = view<std::uint8_t>(self, detail.colour, shape);
    return maps;
}

RecordFile file_from(const py::handle& value) {
    const auto file = py::cast<py::dict>(value);
    return {py::cast<std::string>(file["name"]), py::cast<std::string>(file["role"]),
            py::cast<std::string>(file["sha256"]), py::cast<std::uint64_t>(file["bytes"])};
}

std::string record_text(const ImportedScan& scan, const py::dict& about, const py::list& inputs,
                        const py::list& outputs) {
    ScanRecord record = record_of(scan);
    const auto text = [&about](const char* key) {
        return about.contains(key) ? py::cast<std::string>(about[key]) : std::string();
    };
    record.object_id = text("object_id");
    record.title = text("title");
    record.holder = text("holder");
    record.rights = text("rights");
    record.created_utc = text("created_utc");
    record.software_version = TOGISHI_VERSION;
    for (const auto& file : inputs) record.inputs.push_back(file_from(file));
    for (const auto& file : outputs) record.outputs.push_back(file_from(file));
    return record_json(record);
}

/// mesh: makes the scan's mesh, without the interpreter's lock.
template <class Mesh>
std::shared_ptr<ImportedScan> run(const Mesh& mesh, const py::dict& options,
                                  const py::object& painted, const py::object& progress) {
    const ImportOptions chosen = options_from(options, painted);
    ImportProgress report;
    if (!progress.is_none()) {
        report = [&progress](double done) {
            const py::gil_scoped_acquire acquire;
            return progress(done).ptr() != Py_False;
        };
    }
    try {
        const py::gil_scoped_release release;
        return std::make_shared<ImportedScan>(import_scan(mesh(), chosen, report));
    } catch (const PrepareCancelled&) {
        PyErr_SetString(PyExc_InterruptedError, "scan: cancelled");
        throw py::error_already_set();
    }
}

std::shared_ptr<ImportedScan> run_arrays(const Array<float>& positions,
                                         const Array<std::int32_t>& triangles,
                                         const py::object& colours,
                                         const std::array<double, 3>& origin,
                                         const py::dict& options, const py::object& painted,
                                         const py::object& progress) {
    TriangleMesh mesh = mesh_from(positions, triangles, colours, origin);
    return run([&mesh] { return std::move(mesh); }, options, painted, progress);
}

std::shared_ptr<ImportedScan> run_file(const std::filesystem::path& path, const py::dict& options,
                                       const py::object& painted, const py::object& progress) {
    return run([&path] { return read_own_mesh(path).mesh; }, options, painted, progress);
}

}  // namespace

void bind_scan(py::module_& m) {
    py::class_<ImportedScan, std::shared_ptr<ImportedScan>> sword(
        m, "ScannedSword", "A scanned blade; arrays as Katana has them.");
    bind_blade_arrays(sword, &finest);
    sword
        .def_property_readonly(
            "frame", [](const py::object& self) { return frame_to_python(finest(self).frame); })
        .def_property_readonly("report", [](const ImportedScan& s) { return report_of(s); })
        .def_property_readonly("maps", &maps_of)
        .def_property_readonly("painted",
                               [](const ImportedScan& s) -> py::object {
                                   if (s.painted.empty()) return py::none();
                                   return py::array_t<std::int32_t>(
                                       static_cast<py::ssize_t>(s.painted.size()),
                                       s.painted.data());
                               })
        .def_property_readonly(
            "aside",
            [](const py::object& self) {
                py::list all;
                for (const AsidePiece& piece : self.cast<const ImportedScan&>().aside) {
                    all.append(py::dict(
                        py::arg("positions_mm") = view<float>(self, piece.mesh.positions),
                        py::arg("triangles") = view<std::uint32_t>(self, piece.mesh.triangles),
                        py::arg("text") = piece.text));
                }
                return all;
            })
        .def("record", &record_text, py::arg("about"), py::arg("inputs"), py::arg("outputs"),
             "The record as JSON-LD. about: object_id, title, holder, rights, created_utc; files: "
             "name, role, sha256, bytes.");
    m.def("scan_import", &run_arrays, py::arg("positions"), py::arg("triangles"),
          py::arg("colours"), py::arg("origin"), py::arg("options"), py::kw_only(),
          py::arg("painted") = py::none(), py::arg("progress") = py::none(),
          "From a scan's arrays (float32 positions told from origin, in the file's unit) to a "
          "blade. progress: called with the share done; returning False cancels "
          "(InterruptedError).");
    m.def("scan_import_file", &run_file, py::arg("path"), py::arg("options"), py::kw_only(),
          py::arg("painted") = py::none(), py::arg("progress") = py::none(),
          "As scan_import(), from a PLY, OBJ or STL file, which is held to what it promises.");
    m.def(
        "check_gltf",
        [](const std::filesystem::path& path) {
            const py::gil_scoped_release release;
            check_gltf(path);
        },
        py::arg("path"),
        "Hold a glTF or GLB file to what it promises before another program reads it. InputError "
        "names what is wrong.");
}

}  // namespace togishi
