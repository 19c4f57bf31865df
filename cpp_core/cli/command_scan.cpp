// togishi scan: a scanned sword as a measured blade, with its maps and the record of what was done.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/sha256.hpp"
#include "blade/katana_file.hpp"
#include "cli/commands.hpp"
#include "image/float_image.hpp"
#include "image/picture_file.hpp"
#include "mesh_file/read_mesh.hpp"
#include "mesh_file/write_ply.hpp"
#include "scanned/import.hpp"

namespace togishi::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
    std::string file, unit = "auto", output, format = "ply";
    std::vector<std::string> corrections;
    std::vector<double> machi;
    bool force = false, no_maps = false;
    ImportOptions import;
    ScanRecord about;
};

// The files that are written, by what they are.
class Output {
  public:
    Output(const Options& o, std::size_t levels, bool colours, std::size_t aside)
        : folder_(o.output), stem_(fs::path(o.file).stem().string()) {
        add("blade", "." + o.format);
        for (std::size_t i = 1; i < levels; ++i)
            add("level " + std::to_string(i), "-level" + std::to_string(i) + "." + o.format);
        if (!o.no_maps) {
            add("normal map", "-normal.tif");
            add("displacement map", "-displacement.exr");
            add("map of what was seen", "-seen.png");
            if (colours) add("colour map", "-colour.png");
        }
        for (std::size_t i = 1; i <= aside; ++i)
            add("aside " + std::to_string(i), "-aside" + std::to_string(i) + ".ply");
        add("report", ".json");
        add("record", ".jsonld");
    }
    // Throws InputError; replace: only for the scan itself.
    void refuse_existing(const fs::path& input, bool replace) const {
        for (const auto& [role, path] : files_) {
            std::error_code error;
            if (!fs::exists(path, error)) continue;
            if (fs::equivalent(path, input, error))
                throw InputError(path.string(), "file", "the scan itself", "another folder");
            if (!replace)
                throw InputError(path.string(), "file", "there already", "--force to replace it");
        }
    }
    [[nodiscard]] const fs::path& path(const std::string& role) const {
        return std::find_if(files_.begin(), files_.end(),
                            [&](const auto& file) { return file.first == role; })
            ->second;
    }
    [[nodiscard]] const auto& files() const { return files_; }

  private:
    void add(const std::string& role, const std::string& end) {
        files_.emplace_back(role, folder_ / (stem_ + end));
    }
    fs::path folder_;
    std::string stem_;
    std::vector<std::pair<std::string, fs::path>> files_;
};

RecordFile file_facts(const fs::path& path, const std::string& role) {
    std::ifstream in(path, std::ios::binary);
    std::error_code error;
    const auto bytes = fs::file_size(path, error);
    if (!in || error) throw InputError(path.string(), "file", "missing or unreadable", "a file");
    Sha256 hash;
    std::vector<char> block(std::size_t{1} << 20U);
    while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0)
        hash.add({block.data(), static_cast<std::size_t>(in.gcount())});
    return {path.filename().string(), role, hash.hex(), bytes};
}

void set_options(Options& o) {
    if (o.unit != "auto") {
        const auto unit = std::find_if(length_units.begin(), length_units.end(),
                                       [&](LengthUnit u) { return name_of(u) == o.unit; });
        if (unit == length_units.end())
            throw InputError("--unit", "argument", o.unit, "auto, mm, cm, m, inch");
        o.import.mm_per_unit = millimetres_in(*unit);
    }
    for (const std::string& what : o.corrections) {
        if (what == "ends") {
            o.import.analysis.correction.swap_ends = true;
        } else if (what == "edge") {
            o.import.analysis.correction.swap_edge_and_back = true;
        } else {
            throw InputError("--correct", "argument", what, "ends, edge");
        }
    }
    if (!o.machi.empty()) o.import.machi = glm::dvec3(o.machi[0], o.machi[1], o.machi[2]);
    if (o.format != "ply" && o.format != "obj")
        throw InputError("--format", "argument", o.format, "ply, obj");
    o.import.prepare.maps = !o.no_maps;
}

// Rows of a map, the top one (v = 1) first.
template <class Write>
void from_top(const DetailMaps& maps, Write&& write) {
    for (std::size_t row = maps.height; row-- > 0;) {
        for (std::size_t i = row * maps.width; i < (row + 1) * maps.width; ++i) write(i);
    }
}

FloatImage picture(const DetailMaps& maps, int channels) {
    FloatImage image;
    image.width = static_cast<int>(maps.width);
    image.height = static_cast<int>(maps.height);
    image.channels = channels;
    image.values.reserve(maps.width * maps.height * static_cast<std::size_t>(channels));
    image.notes["Software"] = "togishi " TOGISHI_VERSION;
    return image;
}

void write_maps(const DetailMaps& maps, const Output& output) {
    FloatImage normal = picture(maps, 3);
    normal.names = {"R", "G", "B"};
    from_top(maps, [&](std::size_t i) {
        for (int k = 0; k < 3; ++k) normal.values.push_back(0.5F + 0.5F * maps.normal[i][k]);
    });
    write_float_image(output.path("normal map"), normal);
    FloatImage displacement = picture(maps, 1);
    displacement.names = {"Y"};
    from_top(maps, [&](std::size_t i) { displacement.values.push_back(maps.displacement_mm[i]); });
    write_float_image(output.path("displacement map"), displacement);
    const int width = static_cast<int>(maps.width);
    const int height = static_cast<int>(maps.height);
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * maps.state.size());
    from_top(maps, [&](std::size_t i) {
        constexpr std::array<std::uint8_t, 3> grey{0, 255, 128};  // outside, measured, hole
        rgb.insert(rgb.end(), 3, grey[static_cast<std::size_t>(maps.state[i])]);
    });
    write_png(output.path("map of what was seen"), width, height, rgb);
    if (maps.colour.empty()) return;
    rgb.clear();
    from_top(maps, [&](std::size_t i) {
        rgb.insert(rgb.end(), maps.colour[i].begin(), maps.colour[i].begin() + 3);
    });
    write_png(output.path("colour map"), width, height, rgb);
}

Json report_of(const ImportedScan& scan) {
    const ScanAnalysis& found = scan.analysis;
    Json report{{"verdict", verdict_name(found.verdict)},
                {"text", found.text},
                {"doubts", found.doubts},
                {"unit", {{"mm_per_unit", scan.mm_per_unit}, {"text", scan.unit_text}}},
                {"zukuri", found.zukuri},
                {"mune", found.mune_type},
                {"noise_mm", found.noise_mm}};
    Json dimensions = Json::object();
    for (const ScanMeasure& m : found.measures) {
        dimensions[m.name] = {{"value", m.value}, {"sigma", m.sigma}, {"unit", m.unit}};
        if (m.inferred) dimensions[m.name]["inferred"] = true;
        if (!m.note.empty()) dimensions[m.name]["note"] = m.note;
    }
    report["dimensions"] = dimensions;
    Json taper = Json::array();
    for (const TaperPoint& t : found.taper) {
        taper.push_back({{"s_mm", t.s_mm},
                         {"width_mm", t.width_mm},
                         {"kasane_mm", t.kasane_mm},
                         {"shinogi_haba_mm", t.shinogi_haba_mm},
                         {"shinogi_kasane_mm", t.shinogi_kasane_mm}});
    }
    report["taper"] = taper;
    report["holes"] = {{"count", scan.holes}, {"closed", scan.closing.closed}};
    report["inferred"] = scan.inferred;
    Json seconds = Json::object();
    for (const auto& [step, time] : scan.time) seconds[step] = time.seconds;
    report["seconds"] = seconds;
    if (!scan.is_blade()) return report;
    Json levels = Json::array();
    for (const PreparedLevel& level : scan.blade.levels) {
        levels.push_back({{"faces", level.mesh.face_count()},
                          {"asked_mm", level.error_mm},
                          {"largest_mm", level.distance.largest},
                          {"rms_mm", level.distance.rms}});
    }
    report["levels"] = levels;
    const SettledCount& settled = scan.blade.settled;
    report["settled"] = {{"moved", settled.moved},      {"slid", settled.slid},
                         {"flipped", settled.flipped},  {"collapsed", settled.collapsed},
                         {"left", settled.left},        {"stretched_mm2", settled.stretched_mm2},
                         {"left_mm2", settled.left_mm2}};
    const BladeFrame& frame = scan.blade.levels.front().mesh.frame;
    Json chart = Json::object();
    for (const auto& [name, member] : frame_lengths) chart[std::string(name)] = frame.*member;
    for (const auto& [name, member] : frame_curves) chart[std::string(name)] = frame.*member;
    report["frame"] = chart;
    Json aside = Json::array();
    for (const AsidePiece& piece : scan.aside) aside.push_back(piece.text);
    report["aside"] = aside;
    return report;
}

void print(const ImportedScan& scan) {
    const ScanAnalysis& found = scan.analysis;
    std::cout << found.text << '\n' << scan.unit_text << '\n';
    for (const std::string& doubt : found.doubts) std::cout << "? " << doubt << '\n';
    for (const ScanMeasure& m : found.measures) {
        std::array<char, 160> line{};
        const int digits = m.sigma >= 0.95 ? 1 : m.sigma >= 0.0095 ? 2 : 3;
        const std::string label = measure_label(m.name);
        if (m.sigma > 0) {
            std::snprintf(line.data(), line.size(), "  %-22s %10.*f ± %.*f %s", label.c_str(),
                          digits, m.value, digits, m.sigma, m.unit.c_str());
        } else {
            std::snprintf(line.data(), line.size(), "  %-22s %10.2f %s", label.c_str(), m.value,
                          m.unit.c_str());
        }
        std::cout << line.data();
        if (m.inferred) std::cout << "  inferred";
        if (!m.note.empty()) std::cout << "  (" << m.note << ')';
        std::cout << '\n';
    }
    if (!found.mune_type.empty()) std::cout << "  Mune: " << found.mune_type << '\n';
    for (const AsidePiece& piece : scan.aside) std::cout << "  Kept aside: " << piece.text << '\n';
}

std::string now_utc() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    (void)std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text.data();
}

void run(Options& o, const Common& common) {
    set_options(o);
    const fs::path input(o.file);
    const bool writes = !o.output.empty();
    if (writes) {
        std::error_code error;
        fs::create_directories(o.output, error);
        check_output_folder(fs::path(o.output) / "file");
        // Before the long work; how many pieces lie aside is not known yet.
        Output(o, o.import.prepare.levels, true, 0).refuse_existing(input, o.force);
    } else {
        o.import.prepare.maps = false;
        o.import.prepare.levels = 1;
    }
    MeshFile file = read_mesh(input);
    if (o.import.mm_per_unit == 0 && file.unit == "m") o.import.mm_per_unit = 1000;
    RecordStep read{"read",
                    {{"format", file.format}},
                    {{"triangles", static_cast<double>(file.mesh.triangles.size()), ""},
                     {"vertices", static_cast<double>(file.mesh.positions.size()), ""},
                     {"polygons cut", static_cast<double>(file.polygons), ""}},
                    file.notes};
    const bool colours = !file.mesh.colours.empty();
    const bool told = isatty(STDERR_FILENO) != 0;
    const ImportedScan scan = import_scan(std::move(file.mesh), o.import, [&](double share) {
        if (told) std::cerr << '\r' << std::lround(100 * share) << " %" << std::flush;
        return true;
    });
    if (told) std::cerr << "\r      \r";
    Json report = report_of(scan);
    if (writes && scan.is_blade()) {
        const Output output(o, scan.blade.levels.size(), colours, scan.aside.size());
        output.refuse_existing(input, o.force);
        for (std::size_t i = 0; i < scan.blade.levels.size(); ++i) {
            const std::string role = i == 0 ? "blade" : "level " + std::to_string(i);
            write_katana_mesh(output.path(role), scan.blade.levels[i].mesh);
        }
        if (!o.no_maps) write_maps(scan.blade.detail, output);
        for (std::size_t i = 0; i < scan.aside.size(); ++i) {
            write_ply(output.path("aside " + std::to_string(i + 1)), scan.aside[i].mesh,
                      scan.aside[i].text, true);
        }
        for (const auto& [role, path] : output.files()) report["files"][role] = path.string();
        write_text_file(output.path("report"), report.dump(1) + "\n");
        ScanRecord record = record_of(scan);
        record.object_id = o.about.object_id;
        record.title = o.about.title;
        record.holder = o.about.holder;
        record.rights = o.about.rights;
        record.software_version = TOGISHI_VERSION;
        record.created_utc = now_utc();
        record.steps.insert(record.steps.begin(), read);
        record.inputs.push_back(file_facts(input, "scan"));
        for (const auto& [role, path] : output.files()) {
            if (role != "record") record.outputs.push_back(file_facts(path, role));
        }
        write_text_file(output.path("record"), record_json(record));
    }
    if (common.json) {
        std::cout << report.dump(1) << '\n';
    } else {
        print(scan);
        if (report.contains("files"))
            std::cout << "Written: " << report["files"]["blade"].get<std::string>() << " and "
                      << report["files"].size() - 1 << " files beside it\n";
    }
    if (!scan.is_blade())
        throw InputError(o.file, "scan", std::string(verdict_name(scan.analysis.verdict)),
                         "one blade; nothing was written");
}

}  // namespace

void add_scan_command(CLI::App& app, const Common& common) {
    auto o = std::make_shared<Options>();
    auto* command = app.add_subcommand(
        "scan", "Measure a scanned sword and make it a blade that takes every material and map");
    command->add_option("file", o->file, "The scan: .ply, .obj, .stl, .gltf or .glb")->required();
    command->add_option("-o,--out", o->output,
                        "Folder for blade, maps, report and record; without: dimensions only");
    command->add_option("--unit", o->unit, "Of the file: auto (by the length), mm, cm, m, inch")
        ->capture_default_str();
    command
        ->add_option("--correct", o->corrections,
                     "What was found the wrong way round: ends (tip and tang), edge (and back)")
        ->delimiter(',');
    command
        ->add_option(
            "--machi", o->machi,
            "X,Y,Z of a point beside the machi, as the file has it, where it was not found")
        ->delimiter(',')
        ->expected(3);
    command
        ->add_option("--kissaki", o->import.analysis.correction.kissaki_mm,
                     "mm from the yokote to the tip, where it was not found; 0: no yokote")
        ->check(CLI::NonNegativeNumber);
    command
        ->add_option("--error", o->import.prepare.error_mm,
                     "mm between the lighter mesh and the scan; 0: 0.05, or 8 times its noise")
        ->capture_default_str();
    command
        ->add_option(
            "--replicates", o->import.analysis.replicates,
            "Fits to the scan with its own noise once more, for the uncertainties; 0: none")
        ->capture_default_str()
        ->check(CLI::Range(0, 1000));
    command->add_option("--levels", o->import.prepare.levels, "Levels of detail, 1 to 6")
        ->capture_default_str();
    command->add_option("--width", o->import.prepare.detail.width, "Texels along the blade")
        ->capture_default_str();
    command->add_flag("--no-maps", o->no_maps, "No normal map, displacement and colours");
    command
        ->add_option("--close-holes", o->import.close_holes_mm,
                     "Close holes whose border is no longer than this (mm)")
        ->capture_default_str();
    command->add_option("--format", o->format, "Of the meshes: ply, obj")->capture_default_str();
    command->add_flag("--force", o->force, "Replace files that are there");
    command->add_option("--object", o->about.object_id, "Inventory number, for the record");
    command->add_option("--title", o->about.title, "What the sword is called, for the record");
    command->add_option("--holder", o->about.holder, "Who keeps it, for the record");
    command->add_option("--rights", o->about.rights, "Rights or licence, for the record");
    command->callback([o, &common] { run(*o, common); });
}

}  // namespace togishi::cli
