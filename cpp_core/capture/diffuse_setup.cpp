#include "capture/diffuse_setup.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "base/text.hpp"
#include "blade/katana_file.hpp"
#include "brdf/toml_reader.hpp"
#include "spectral/embedded_data.hpp"
#include "steel/steel_parameters.hpp"

namespace togishi {
namespace {

using material_file::number_text;
using material_file::quoted;
using material_file::Reader;
using material_file::Source;
using material_file::text_of;

constexpr std::size_t max_setup_bytes = 1 << 20;
constexpr double most = 1e9;

std::vector<double> numbers(Reader& reader, std::string_view key, std::size_t count,
                            std::string_view allowed) {
    const toml::node& node = reader.require(key, allowed);
    const toml::array* list = node.as_array();
    if (list == nullptr || (count > 0 && list->size() != count))
        reader.fail(node, key, text_of(node), allowed);
    std::vector<double> values;
    values.reserve(list->size());
    for (const toml::node& one : *list)
        values.push_back(reader.checked_number(one, key, -most, most, allowed));
    return values;
}

glm::dvec3 vector3(Reader& reader, std::string_view key) {
    const auto v = numbers(reader, key, 3, "three numbers");
    return {v[0], v[1], v[2]};
}

bool has(Reader& reader, std::string_view key) {
    return reader.find(key) != nullptr;
}

double number_or(Reader& reader, std::string_view key, double otherwise, double least, double high,
                 std::string_view allowed) {
    return has(reader, key) ? reader.number(key, least, high, allowed) : otherwise;
}

// How a camera is to be found that the file does not state.
struct ByLandmarks {
    glm::dvec3 facing{0, 1, 0};
    double max_residual_mm = 2;
};

Camera read_camera(Reader& reader, const std::string& where, std::optional<ByLandmarks>& search,
                   SilhouetteSetup& silhouette) {
    Camera camera;
    silhouette.file = reader.text("silhouette", "a picture", true);
    silhouette.search_mm =
        number_or(reader, "search_mm", silhouette.search_mm, 1e-3, 1000, "above 0, to 1000 mm");
    const std::string kind = reader.text("kind", "orthographic or pinhole", false);
    camera.pinhole = kind == "pinhole";
    if (!camera.pinhole && kind != "orthographic")
        reader.fail(*reader.find("kind"), "kind", kind, "orthographic or pinhole");
    const auto size = [&](std::string_view key) {
        return static_cast<int>(reader.number(key, 1, 100000, "1 to 100000 pixels"));
    };
    camera.width_px = size("width_px");
    camera.height_px = size("height_px");
    if (!has(reader, "position_mm")) {
        search.emplace();
        if (has(reader, "facing")) search->facing = vector3(reader, "facing");
        search->max_residual_mm = number_or(reader, "max_residual_mm", 2, 1e-6, 1e6, "above 0 mm");
        reader.refuse_unknown();
        return camera;
    }
    camera.scale =
        reader.number(camera.pinhole ? "focal_px" : "scale_px_per_mm", 1e-6, most, "above 0");
    camera.centre_px = glm::dvec2(camera.width_px, camera.height_px) * 0.5;
    if (has(reader, "centre_px")) {
        const auto v = numbers(reader, "centre_px", 2, "two numbers");
        camera.centre_px = {v[0], v[1]};
    }
    camera.position_mm = vector3(reader, "position_mm");
    camera.right = vector3(reader, "right");
    camera.down = vector3(reader, "down");
    reader.refuse_unknown();
    check_camera(camera, where);
    return camera;
}

DiffuseSource read_source(Reader& reader, const std::string& where) {
    DiffuseSource source;
    const std::string kind = reader.text("kind", "rectangle, disk or hemisphere", false);
    const auto* const found = std::find(source_kind_names.begin(), source_kind_names.end(), kind);
    if (found == source_kind_names.end())
        reader.fail(*reader.find("kind"), "kind", kind, "rectangle, disk or hemisphere");
    source.kind = static_cast<SourceKind>(found - source_kind_names.begin());
    if (source.kind == SourceKind::hemisphere) {
        const glm::dvec3 axis = vector3(reader, "axis");
        if (!(glm::length(axis) > 1e-9))
            reader.fail(*reader.find("axis"), "axis", "of length 0", "a direction");
        source.far_away = !has(reader, "radius_mm");
        const double radius =
            source.far_away ? 1 : reader.number("radius_mm", 1e-3, most, "above 0 mm");
        source.half_u_mm = glm::normalize(axis) * radius;
        if (!source.far_away) source.centre_mm = vector3(reader, "centre_mm");
    } else {
        source.centre_mm = vector3(reader, "centre_mm");
        source.half_u_mm = vector3(reader, "half_u_mm");
        source.half_v_mm = vector3(reader, "half_v_mm");
    }
    source.radiance = number_or(reader, "radiance", 1, 1e-12, 1e12, "above 0");
    reader.refuse_unknown();
    check_source(source, where);
    return source;
}

KatanaPreset preset_of(const std::string& name, const CaptureSetup& setup) {
    const std::string path = "blades/" + name + ".toml";
    for (const EmbeddedFile& file : embedded_files())
        if (file.path == path) return parse_katana_preset(file.text, file.path);
    const std::filesystem::path file = setup.path_of(name);
    return parse_katana_preset(read_text_file(file, max_setup_bytes, "a blade preset (TOML)"),
                               file.string());
}

CaptureSurface read_surface(Reader& reader, const Source& source, const CaptureSetup& setup) {
    const std::string kind = reader.text("kind", "plate, plane, blade or none", false);
    CaptureSurface surface;
    if (kind == "plate") {
        Plate plate;
        const auto size = numbers(reader, "size_mm", 2, "two lengths in mm");
        plate.size_mm = {size[0], size[1]};
        if (has(reader, "bend_radius_mm")) {
            const auto radius = numbers(reader, "bend_radius_mm", 2, "two radii in mm, 0: flat");
            plate.bend_radius_mm = {radius[0], radius[1]};
        }
        surface = plate;
    } else if (kind == "plane") {
        surface = PlaneSurface{vector3(reader, "point_mm"), vector3(reader, "normal"),
                               vector3(reader, "tangent")};
    } else if (kind == "blade") {
        BladeSurface blade;
        blade.preset = reader.text("preset", "a preset's name or file", true);
        if (!blade.preset.empty()) blade.parameters = preset_of(blade.preset, setup).parameters;
        blade.detail = number_or(reader, "detail", 1, 0.002, 64, "0.002 to 64");
        if (has(reader, "katana")) {
            const toml::table& table = reader.table("katana");
            for (const auto& [key, node] : table) {
                if (const auto value = node.value<double>()) {
                    set_katana_value(blade.parameters, key.str(), *value, source.where);
                } else {
                    set_katana_value(blade.parameters, key.str(),
                                     std::string_view(node.value_or(std::string())), source.where);
                }
            }
        }
        check_katana(blade.parameters, source.where);
        surface = blade;
    } else if (kind != "none") {
        reader.fail(*reader.find("kind"), "kind", kind, "plate, plane, blade or none");
    }
    reader.refuse_unknown();
    return surface;
}

SimulateSetup read_simulate(Reader& reader) {
    SimulateSetup s;
    s.maps = reader.text("maps", "an .exr of property maps", true);
    s.lights = reader.text("lights", "an .lp file", true);
    s.map_width = static_cast<int>(
        number_or(reader, "map_width", s.map_width, 1, 32768, "1 to 32768 texels"));
    s.map_height = static_cast<int>(
        number_or(reader, "map_height", s.map_height, 1, 32768, "1 to 32768 texels"));
    s.variation = number_or(reader, "variation", s.variation, 0, 1, "0 to 1");
    s.blur_px = number_or(reader, "blur_px", s.blur_px, 0, 100, "0 to 100 pixels");
    s.dark = number_or(reader, "dark", s.dark, 0, 0.9, "0 to 0.9 of full scale");
    s.vignetting = number_or(reader, "vignetting", s.vignetting, 0, 0.95, "0 to 0.95");
    s.seed = static_cast<std::uint64_t>(
        number_or(reader, "seed", 1, 0, 9e15, "a whole number, 0 or more"));
    if (has(reader, "exposures")) {
        s.exposures = numbers(reader, "exposures", 0, "one factor or more");
        for (const double e : s.exposures) {
            if (!(e > 0))
                reader.fail(*reader.find("exposures"), "exposures", number_text(e), "above 0");
        }
    }
    if (has(reader, "pattern")) {
        const toml::table& table = reader.table("pattern");
        for (const auto& [key, node] : table) {
            const auto value = node.value<double>();
            if (!value) reader.fail(node, key.str(), text_of(node), "a number");
            s.pattern[std::string(key.str())] = *value;
        }
    }
    reader.refuse_unknown();
    return s;
}

// The tables of a list of tables.
std::vector<const toml::table*> tables(Reader& reader, std::string_view key) {
    std::vector<const toml::table*> result;
    const toml::node* node = reader.find(key);
    if (node == nullptr) return result;
    const toml::array* list = node->as_array();
    if (list == nullptr)
        reader.fail(*node, key, text_of(*node), "tables [[" + std::string(key) + "]]");
    for (const toml::node& one : *list) {
        if (!one.is_table()) reader.fail(one, key, text_of(one), "a table");
        result.push_back(one.as_table());
    }
    return result;
}

std::string text(const glm::dvec3& v) {
    return "[" + number_text(v.x) + ", " + number_text(v.y) + ", " + number_text(v.z) + "]";
}
std::string text(const glm::dvec2& v) {
    return "[" + number_text(v.x) + ", " + number_text(v.y) + "]";
}

void write_source(std::ostream& out, const DiffuseSource& source) {
    out << "[photograph.source]\nkind = "
        << quoted(std::string(source_kind_names[static_cast<std::size_t>(source.kind)])) << '\n';
    if (source.kind == SourceKind::hemisphere) {
        out << "axis = " << text(glm::normalize(source.half_u_mm)) << '\n';
        if (!source.far_away) {
            out << "radius_mm = " << number_text(glm::length(source.half_u_mm))
                << "\ncentre_mm = " << text(source.centre_mm) << '\n';
        }
    } else {
        out << "centre_mm = " << text(source.centre_mm)
            << "\nhalf_u_mm = " << text(source.half_u_mm)
            << "\nhalf_v_mm = " << text(source.half_v_mm) << '\n';
    }
    if (source.radiance != 1) out << "radiance = " << number_text(source.radiance) << '\n';
}

void write_surface(std::ostream& out, const CaptureSurface& surface) {
    if (const auto* plate = std::get_if<Plate>(&surface)) {
        out << "\n[surface]\nkind = \"plate\"\nsize_mm = " << text(plate->size_mm)
            << "\nbend_radius_mm = " << text(plate->bend_radius_mm) << '\n';
    } else if (const auto* plane = std::get_if<PlaneSurface>(&surface)) {
        out << "\n[surface]\nkind = \"plane\"\npoint_mm = " << text(plane->point_mm)
            << "\nnormal = " << text(plane->normal) << "\ntangent = " << text(plane->tangent)
            << '\n';
    } else if (const auto* blade = std::get_if<BladeSurface>(&surface)) {
        out << "\n[surface]\nkind = \"blade\"\ndetail = " << number_text(blade->detail)
            << "\n[surface.katana]\n";
        for (const ChoiceField& c : katana_choices()) {
            out << c.key << " = "
                << quoted(std::string(c.names[static_cast<std::size_t>(c.get(blade->parameters))]))
                << '\n';
        }
        for (const DimensionField& d : katana_dimensions())
            out << d.key << " = " << number_text(blade->parameters.*d.member) << '\n';
    } else {
        out << "\n[surface]\nkind = \"none\"\n";
    }
}

}  // namespace

std::filesystem::path CaptureSetup::path_of(const std::string& name) const {
    const std::filesystem::path path(name);
    return path.is_absolute() ? path : file.parent_path() / path;
}

CaptureSetup capture_setup_from_toml(std::string_view toml_text,
                                     const std::filesystem::path& file) {
    const Source source{file.string(), SourceLines::shown};
    toml::table table;
    try {
        table = toml::parse(checked_text(toml_text, source.where), source.where);
    } catch (const toml::parse_error& error) {
        throw InputError(source.where + ":" + std::to_string(error.source().begin.line), "TOML",
                         std::string(error.description()), "a set-up of photographs");
    }
    Reader reader(table, "", source);
    (void)reader.number("format", 1, 1, "1");
    CaptureSetup setup;
    setup.file = file;
    if (has(reader, "material")) setup.material = reader.text("material", "a name", false);
    if (has(reader, "light")) setup.light = reader.text("light", "a spectrum", false);
    if (has(reader, "transfer")) setup.transfer = reader.text("transfer", "a transfer", false);
    check_transfer(setup.transfer, source.where);
    if (has(reader, "scale")) setup.scale = reader.number("scale", 1e-12, 1e12, "above 0");
    setup.flat_reflectance = number_or(reader, "flat_reflectance", 1, 0.01, 1, "0.01 to 1");
    if (has(reader, "noise")) {
        Reader noise(reader.table("noise"), "noise.", source);
        SensorOptions sensor;
        sensor.snr = noise.number("snr", 0, 1e9, "0 (none) or more");
        sensor.read = noise.number("read", 0, 1, "0 to 1 of full scale");
        sensor.bits = static_cast<int>(noise.number("bits", 0, 32, "0 (not rounded) to 32"));
        noise.refuse_unknown();
        setup.noise = sensor;
    }
    std::optional<ByLandmarks> search;
    if (has(reader, "camera")) {
        Reader camera(reader.table("camera"), "camera.", source);
        setup.camera = read_camera(camera, source.where, search, setup.silhouette);
    }
    if (has(reader, "surface")) {
        Reader surface(reader.table("surface"), "surface.", source);
        setup.surface = read_surface(surface, source, setup);
    }
    std::size_t index = 0;
    for (const toml::table* one : tables(reader, "photograph")) {
        const std::string prefix = "photograph[" + std::to_string(++index) + "].";
        Reader r(*one, prefix, source);
        PhotographSetup photograph;
        photograph.file = r.text("file", "a picture", true);
        photograph.dark = r.text("dark", "a picture", true);
        photograph.flat = r.text("flat", "a picture", true);
        photograph.exposure = number_or(r, "exposure", 1, 1e-9, 1e9, "above 0");
        photograph.flat_exposure = number_or(r, "flat_exposure", 1, 1e-9, 1e9, "above 0");
        if (has(r, "source")) {
            Reader s(r.table("source"), prefix + "source.", source);
            photograph.source = read_source(s, source.where);
        }
        r.refuse_unknown();
        setup.photographs.push_back(std::move(photograph));
    }
    index = 0;
    for (const toml::table* one : tables(reader, "reference")) {
        Reader r(*one, "reference[" + std::to_string(++index) + "].", source);
        const auto box = numbers(r, "box_px", 4, "[x, y, width, height]");
        ReferenceArea area;
        area.x = static_cast<int>(box[0]);
        area.y = static_cast<int>(box[1]);
        area.width = static_cast<int>(box[2]);
        area.height = static_cast<int>(box[3]);
        const std::string part = r.text("part", "ji or ha", false);
        if (part != "ji" && part != "ha") r.fail(*r.find("part"), "part", part, "ji or ha");
        area.ha = part == "ha";
        area.mu_deg = number_or(r, "mu_deg", 0, 0, 80, "0 to 80 degrees");
        r.refuse_unknown();
        setup.references.push_back(area);
    }
    const auto* blade = std::get_if<BladeSurface>(&setup.surface);
    const auto rough_mesh = [&] {
        if (blade == nullptr)
            throw InputError(source.where, "surface", "no blade",
                             "a blade, whose landmarks give the camera");
        constexpr double detail = 0.02;  // a landmark is a vertex at any
        return make_katana(blade->parameters, detail);
    };
    std::optional<KatanaMesh> mesh;
    index = 0;
    for (const toml::table* one : tables(reader, "landmark")) {
        Reader r(*one, "landmark[" + std::to_string(++index) + "].", source);
        Landmark landmark;
        landmark.name = r.text("name", "a name", false);
        const auto pixel = numbers(r, "pixel", 2, "two numbers");
        landmark.pixel = {pixel[0], pixel[1]};
        if (has(r, "point_mm")) {
            landmark.point_mm = vector3(r, "point_mm");
        } else {
            if (!mesh) mesh = rough_mesh();
            landmark.point_mm = blade_landmark(*mesh, landmark.name);
        }
        r.refuse_unknown();
        setup.landmarks.push_back(std::move(landmark));
    }
    if (search) {
        const Camera& asked = *setup.camera;
        setup.camera_fit =
            asked.pinhole
                ? fit_pinhole_camera(setup.landmarks, asked.width_px, asked.height_px,
                                     search->max_residual_mm)
                : fit_orthographic_camera(setup.landmarks, asked.width_px, asked.height_px,
                                          search->facing, search->max_residual_mm);
        setup.camera = setup.camera_fit->camera;
    }
    if (has(reader, "simulate")) {
        Reader s(reader.table("simulate"), "simulate.", source);
        setup.simulate = read_simulate(s);
    }
    reader.refuse_unknown();
    return setup;
}

CaptureSetup read_capture_setup(const std::filesystem::path& file) {
    return capture_setup_from_toml(
        read_text_file(file, max_setup_bytes, "a set-up of photographs (TOML)"), file);
}

std::string capture_setup_to_toml(const CaptureSetup& setup) {
    std::ostringstream out;
    out << "format = 1\nmaterial = " << quoted(setup.material)
        << "\nlight = " << quoted(setup.light) << "\ntransfer = " << quoted(setup.transfer) << '\n';
    if (setup.scale) out << "scale = " << number_text(*setup.scale) << '\n';
    out << "flat_reflectance = " << number_text(setup.flat_reflectance) << '\n';
    if (setup.noise) {
        out << "\n[noise]\nsnr = " << number_text(setup.noise->snr)
            << "\nread = " << number_text(setup.noise->read) << "\nbits = " << setup.noise->bits
            << '\n';
    }
    if (setup.camera) {
        const Camera& c = *setup.camera;
        out << "\n[camera]\nkind = " << (c.pinhole ? "\"pinhole\"" : "\"orthographic\"")
            << "\nwidth_px = " << c.width_px << "\nheight_px = " << c.height_px << '\n'
            << (c.pinhole ? "focal_px = " : "scale_px_per_mm = ") << number_text(c.scale)
            << "\ncentre_px = " << text(c.centre_px) << "\nposition_mm = " << text(c.position_mm)
            << "\nright = " << text(c.right) << "\ndown = " << text(c.down) << '\n';
        if (!setup.silhouette.file.empty()) {
            out << "silhouette = " << quoted(setup.silhouette.file)
                << "\nsearch_mm = " << number_text(setup.silhouette.search_mm) << '\n';
        }
    }
    write_surface(out, setup.surface);
    for (const PhotographSetup& p : setup.photographs) {
        out << "\n[[photograph]]\n";
        if (!p.file.empty()) out << "file = " << quoted(p.file) << '\n';
        if (!p.dark.empty()) out << "dark = " << quoted(p.dark) << '\n';
        if (!p.flat.empty()) out << "flat = " << quoted(p.flat) << '\n';
        out << "exposure = " << number_text(p.exposure) << '\n';
        if (!p.flat.empty()) out << "flat_exposure = " << number_text(p.flat_exposure) << '\n';
        if (p.source) write_source(out, *p.source);
    }
    for (const Landmark& l : setup.landmarks) {
        out << "\n[[landmark]]\nname = " << quoted(l.name) << "\npixel = " << text(l.pixel)
            << "\npoint_mm = " << text(l.point_mm) << '\n';
    }
    for (const ReferenceArea& r : setup.references) {
        out << "\n[[reference]]\nbox_px = [" << r.x << ", " << r.y << ", " << r.width << ", "
            << r.height << "]\npart = " << (r.ha ? "\"ha\"" : "\"ji\"")
            << "\nmu_deg = " << number_text(r.mu_deg) << '\n';
    }
    const SimulateSetup& s = setup.simulate;
    out << "\n[simulate]\n";
    if (!s.maps.empty()) out << "maps = " << quoted(s.maps) << '\n';
    if (!s.lights.empty()) out << "lights = " << quoted(s.lights) << '\n';
    out << "map_width = " << s.map_width << "\nmap_height = " << s.map_height
        << "\nvariation = " << number_text(s.variation) << "\nblur_px = " << number_text(s.blur_px)
        << "\ndark = " << number_text(s.dark) << "\nvignetting = " << number_text(s.vignetting)
        << "\nseed = " << s.seed << "\nexposures = [";
    for (std::size_t k = 0; k < s.exposures.size(); ++k)
        out << (k > 0 ? ", " : "") << number_text(s.exposures[k]);
    out << "]\n";
    if (!s.pattern.empty()) {
        out << "[simulate.pattern]\n";
        for (const auto& [key, value] : s.pattern)
            out << key << " = " << number_text(value) << '\n';
    }
    return out.str();
}

SurfaceView view_of(const CaptureSetup& setup) {
    if (!setup.camera)
        throw InputError(setup.file.string(), "camera", "missing", "a table [camera]");
    if (const auto* plate = std::get_if<Plate>(&setup.surface))
        return view_of_plate(*plate, *setup.camera);
    if (const auto* plane = std::get_if<PlaneSurface>(&setup.surface))
        return view_of_plane(plane->point_mm, plane->normal, plane->tangent, *setup.camera);
    if (const auto* blade = std::get_if<BladeSurface>(&setup.surface))
        return view_of_mesh(make_katana(blade->parameters, blade->detail), *setup.camera);
    throw InputError(setup.file.string(), "surface", "none", "a table [surface]");
}

SurfaceView view_of_flat_card(const CaptureSetup& setup) {
    const SurfaceView view = view_of(setup);
    glm::dvec3 middle(0);
    double count = 0;
    for (std::size_t i = 0; i < view.pixels(); ++i) {
        if (view.seen[i] == 0) continue;
        middle += view.position_mm[i];
        count += 1;
    }
    if (count == 0)
        throw InputError(setup.file.string(), "surface", "not in the picture",
                         "a surface that the camera sees");
    const Camera& camera = view.camera;
    return view_of_plane(middle / count, -camera.forward(), camera.right, camera);
}

void check_transfer(const std::string& transfer, std::string_view where) {
    if (transfer == "linear" || transfer == "srgb") return;
    if (transfer.starts_with("gamma:")) {
        const auto gamma = parse_number(std::string_view(transfer).substr(6));
        if (gamma && *gamma >= 1 && *gamma <= 4) return;
    }
    throw InputError(where, "transfer", transfer, "linear, srgb, or gamma:G with G from 1 to 4");
}

double linear_value(const std::string& transfer, double value) {
    if (transfer == "linear") return value;
    if (transfer == "srgb") {
        // IEC 61966-2-1.
        return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    }
    check_transfer(transfer, "picture");
    return std::pow(std::max(value, 0.0), *parse_number(std::string_view(transfer).substr(6)));
}

}  // namespace togishi
