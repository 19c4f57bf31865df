#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "scanned/import.hpp"
#include "scanned/label_parts.hpp"
#include "scanned/taken_triangles.hpp"

namespace togishi {
namespace {

constexpr std::size_t most_aside = 15;  // more are one piece together
constexpr double speck_mm = 3;          // so are those that are no larger
constexpr double usual_error_mm = 0.05;
constexpr double error_over_noise = 8;
constexpr double painted_within_mm = 0.5;  // of what was painted, for a face to be of its part

void count(RecordStep& step, const char* name, std::size_t number) {
    step.figures.push_back({name, static_cast<double>(number), ""});
}

std::string size_text(const TriangleMesh& mesh) {
    glm::vec3 low(mesh.positions.front());
    glm::vec3 high(low);
    for (const glm::vec3& p : mesh.positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::dvec3 size(high - low);
    return size_in_mm(size.x, size.y, size.z);
}

std::vector<AsidePiece> pieces_aside(const TriangleMesh& mesh, const MeshPieces& pieces,
                                     const ScanAnalysis& analysis) {
    constexpr std::size_t of_blade = ~std::size_t{0};
    std::vector<std::size_t> group(pieces.pieces.size(), of_blade);
    std::size_t own = 0;
    std::size_t specks = 0;
    for (std::size_t i = 0; i < group.size(); ++i) {
        if (analysis.body[i] != 0) continue;
        const MeshPiece& piece = pieces.pieces[i];
        const bool speck = own >= most_aside || glm::length(piece.high - piece.low) <= speck_mm;
        if (speck) ++specks;
        group[i] = speck ? most_aside : own++;
    }
    for (std::size_t& g : group) {
        if (g == most_aside) g = own;
    }
    std::vector<TakenTriangles> taken(own + (specks > 0 ? 1 : 0),
                                      TakenTriangles(mesh, analysis.pose));
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const std::size_t g = group[pieces.of[f]];
        if (g != of_blade) taken[g].add(mesh.triangles[f]);
    }
    std::vector<AsidePiece> aside;
    aside.reserve(taken.size());
    for (std::size_t i = 0; i < taken.size(); ++i) {
        const std::string what = i < own ? "" : std::to_string(specks) + " small pieces within ";
        std::string text = what + size_text(taken[i].mesh);
        aside.push_back({std::move(taken[i].mesh), std::move(text)});
    }
    return aside;
}

// Takes what is no part of the blade out of a mesh.
void keep_blade(TriangleMesh& mesh, const MeshPieces& pieces, const std::vector<char>& body,
                std::vector<Part>& labels) {
    if (std::all_of(body.begin(), body.end(), [](char own) { return own != 0; })) return;
    constexpr std::uint32_t none = 0xffffffffU;
    std::vector<std::uint32_t> place(mesh.positions.size(), none);
    std::size_t kept = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        if (body[pieces.of[f]] == 0) continue;
        labels[kept] = labels[f];
        mesh.triangles[kept++] = mesh.triangles[f];
        for (const std::uint32_t v : mesh.triangles[f]) place[v] = 0;
    }
    mesh.triangles.resize(kept);
    labels.resize(kept);
    std::uint32_t next = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (place[v] == none) continue;
        mesh.positions[next] = mesh.positions[v];
        if (!mesh.colours.empty()) mesh.colours[next] = mesh.colours[v];
        place[v] = next++;
    }
    mesh.positions.resize(next);
    if (!mesh.colours.empty()) mesh.colours.resize(next);
    for (Triangle& t : mesh.triangles) {
        for (std::uint32_t& v : t) v = place[v];
    }
}

void list_holes(ImportedScan& result, TriangleMesh& mesh, double close_mm,
                std::vector<Part>& labels) {
    std::vector<Hole> holes = find_holes(mesh);
    result.holes = holes.size();
    result.longest_hole_mm = holes.empty() ? 0 : holes.front().length;
    RecordStep step{"holes", {{"close_up_to_mm", close_mm}}, {}, {}};
    count(step, "holes", holes.size());
    step.figures.push_back({"longest border", result.longest_hole_mm, "mm"});
    std::erase_if(holes, [&](const Hole& hole) { return hole.length > close_mm; });
    if (!holes.empty()) {
        const std::size_t measured = mesh.triangles.size();
        result.closing = close_holes(mesh, holes);
        // As a neighbour's.
        std::unordered_map<std::uint32_t, Part> about;
        for (const Hole& hole : holes) {
            for (const std::uint32_t v : hole.vertices) about.try_emplace(v, Part::other);
        }
        for (std::size_t f = 0; f < measured; ++f) {
            for (const std::uint32_t v : mesh.triangles[f]) {
                const auto found = about.find(v);
                if (found != about.end()) found->second = labels[f];
            }
        }
        labels.reserve(mesh.triangles.size());
        for (std::size_t f = measured; f < mesh.triangles.size(); ++f)
            labels.push_back(about.at(mesh.triangles[f][0]));
        count(step, "closed", result.closing.closed);
        count(step, "left open", result.closing.left_open);
        count(step, "triangles made", result.closing.triangles_made);
        if (result.closing.closed > 0) {
            result.inferred.push_back(std::to_string(result.closing.closed) +
                                      " holes were closed by flat patches");
        }
    }
    result.steps.push_back(std::move(step));
}

// What the user painted, found again by place.
class Painted {
  public:
    Painted(const PaintedParts& given, const BladePose& pose)
        : part_(given.part), mesh_(moved(given.mesh, pose)), tree_(mesh_) {
        for (std::size_t f = 0; f < part_.size(); ++f) {
            if (part_[f] == PaintedParts::not_painted) continue;
            for (const std::uint32_t v : mesh_.triangles[f]) {
                low_ = glm::min(low_, mesh_.positions[v] - painted_within);
                high_ = glm::max(high_, mesh_.positions[v] + painted_within);
            }
        }
    }
    [[nodiscard]] std::int32_t at(const glm::vec3& p) const {
        for (int i = 0; i < 3; ++i) {
            if (p[i] < low_[i] || p[i] > high_[i]) return PaintedParts::not_painted;
        }
        const SurfaceTree::Nearest found = tree_.nearest(p, painted_within);
        return found.distance < painted_within ? part_[found.triangle] : PaintedParts::not_painted;
    }

  private:
    static constexpr auto painted_within = static_cast<float>(painted_within_mm);
    static TriangleMesh moved(const TriangleMesh& mesh, const BladePose& pose) {
        TriangleMesh result;
        result.triangles = mesh.triangles;
        result.positions.reserve(mesh.positions.size());
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
            result.positions.push_back(on_blade(mesh, v, pose));
        return result;
    }
    const std::vector<std::int32_t>& part_;
    TriangleMesh mesh_;
    SurfaceTree tree_;
    glm::vec3 low_{1e30F}, high_{-1e30F};
};

void paint_labels(const Painted& painted, const TriangleMesh& mesh, const BladePose& pose,
                  std::vector<Part>& labels) {
    constexpr std::size_t grain = 16384;
    parallel_for(labels.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const Triangle& t = mesh.triangles[f];
            const std::int32_t part =
                painted.at((on_blade(mesh, t[0], pose) + on_blade(mesh, t[1], pose) +
                            on_blade(mesh, t[2], pose)) /
                           3.0F);
            if (part != PaintedParts::not_painted) labels[f] = static_cast<Part>(part);
        }
    });
}

std::vector<std::int32_t> painted_faces(const Painted& painted, const BladeMesh& mesh) {
    std::vector<std::int32_t> part(mesh.face_count(), PaintedParts::not_painted);
    for (std::size_t f = 0; f < part.size(); ++f) {
        glm::dvec3 sum(0);
        double corners = 0;
        for (std::int32_t c = mesh.face_start[f]; c < mesh.face_start[f + 1]; ++c) {
            const auto corner = static_cast<std::size_t>(c);
            sum += mesh.positions_mm[static_cast<std::size_t>(mesh.corner_vertex[corner])];
            ++corners;
        }
        part[f] = painted.at(glm::vec3(sum / corners));
    }
    return part;
}

RecordStep label_step(const ImportedScan& result) {
    RecordStep step{"label", {}, {}, {}};
    const BladeMesh& mesh = result.blade.levels.front().mesh;
    std::array<double, part_names.size()> area{};
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const auto at = [&](std::int32_t c) -> const glm::dvec3& {
            return mesh.positions_mm[static_cast<std::size_t>(
                mesh.corner_vertex[static_cast<std::size_t>(c)])];
        };
        const std::int32_t a = mesh.face_start[f];
        for (std::int32_t c = a + 1; c + 1 < mesh.face_start[f + 1]; ++c) {
            area[static_cast<std::size_t>(mesh.face_part[f])] +=
                0.5 * glm::length(glm::cross(at(c) - at(a), at(c + 1) - at(a)));
        }
    }
    for (std::size_t i = 0; i < area.size(); ++i) {
        if (area[i] > 0) step.figures.push_back({std::string(part_names[i]), area[i], "mm2"});
    }
    const auto painted =
        std::count_if(result.painted.begin(), result.painted.end(),
                      [](std::int32_t part) { return part != PaintedParts::not_painted; });
    if (painted > 0) count(step, "faces painted by hand", static_cast<std::size_t>(painted));
    return step;
}

RecordStep prepare_step(const ImportedScan& result, const PrepareOptions& options) {
    RecordStep step{"prepare",
                    {{"error_mm", options.error_mm},
                     {"levels", static_cast<double>(options.levels)},
                     {"level_factor", options.level_factor},
                     {"maps", options.maps}},
                    {},
                    {}};
    const PreparedBlade& blade = result.blade;
    count(step, "triangles of the scan", blade.scan_triangles);
    count(step, "of them cut along borders", blade.cut_triangles);
    for (std::size_t i = 0; i < blade.levels.size(); ++i) {
        const PreparedLevel& level = blade.levels[i];
        const std::string name = "level " + std::to_string(i) + ": ";
        step.figures.push_back(
            {name + "triangles", static_cast<double>(level.mesh.face_count()), ""});
        step.figures.push_back({name + "largest distance", level.distance.largest, "mm"});
        step.figures.push_back({name + "rms distance", level.distance.rms, "mm"});
    }
    count(step, "settled: vertices moved", blade.settled.moved);
    count(step, "settled: slid along the surface", blade.settled.slid);
    count(step, "settled: edges flipped", blade.settled.flipped);
    count(step, "settled: edges collapsed", blade.settled.collapsed);
    count(step, "settled: triangles left stretched", blade.settled.left);
    step.figures.push_back({"settled: area stretched before", blade.settled.stretched_mm2, "mm2"});
    step.figures.push_back({"settled: area left stretched", blade.settled.left_mm2, "mm2"});
    step.figures.push_back({"chart's stretch, 99 % of the area", blade.stretch_99_percent, "%"});
    step.figures.push_back({"chart's stretch, largest", blade.stretch_most_percent, "%"});
    if (options.maps) {
        count(step, "texels along the blade", blade.detail.width);
        count(step, "texels across", blade.detail.height);
    }
    return step;
}

}  // namespace

void finish_import(ImportedScan& result, TriangleMesh mesh, const MeshPieces& pieces,
                   const ImportOptions& options, const ImportProgress& progress) {
    const ScanAnalysis& analysis = result.analysis;
    StepClock clock(result.time);
    const bool told = (analysis.verdict == ScanVerdict::blade ||
                       analysis.verdict == ScanVerdict::part_of_blade) &&
                      !analysis.stations.stations.empty();
    RecordStep measure{"measure", {}, {}, analysis.doubts};
    for (const ScanMeasure& m : analysis.measures)
        measure.figures.push_back({m.name, m.value, m.unit});
    measure.figures.push_back({"noise of a point", analysis.noise_mm, "mm"});
    result.steps.push_back(std::move(measure));
    for (const ScanMeasure& m : analysis.measures) {
        if (m.inferred) result.inferred.push_back(m.name + (m.note.empty() ? "" : ": " + m.note));
    }
    const auto unseen =
        std::count_if(analysis.stations.stations.begin(), analysis.stations.stations.end(),
                      [](const Station& s) { return !s.measured; });
    if (unseen > 0) {
        result.inferred.push_back(std::to_string(unseen) + " of " +
                                  std::to_string(analysis.stations.stations.size()) +
                                  " cross-sections lie over holes of the scan");
    }
    if (!told) return;
    result.inferred.emplace_back(
        "the border of ha and ji: a nominal suguha, for no shape shows the hamon");
    result.aside = pieces_aside(mesh, pieces, analysis);
    std::vector<Part> labels =
        label_parts(mesh, pieces, analysis, ScannedChart(analysis.stations, options.prepare.chart));
    clock.end("label");
    keep_blade(mesh, pieces, analysis.body, labels);
    list_holes(result, mesh, options.close_holes_mm, labels);
    clock.end("holes");
    PrepareOptions prepare = options.prepare;
    if (!(prepare.error_mm > 0))
        prepare.error_mm = std::max(usual_error_mm, error_over_noise * analysis.noise_mm);
    result.error_mm = prepare.error_mm;
    const bool any_painted =
        std::any_of(options.painted.part.begin(), options.painted.part.end(),
                    [](std::int32_t part) { return part != PaintedParts::not_painted; });
    std::unique_ptr<Painted> painted;
    if (any_painted) {
        painted = std::make_unique<Painted>(options.painted, analysis.pose);
        paint_labels(*painted, mesh, analysis.pose, labels);
        clock.end("painted parts");
    }
    result.blade =
        prepare_blade(std::move(mesh), analysis.pose, analysis.stations, labels, prepare, progress);
    for (const auto& [step, time] : result.blade.time) result.time[step] = time;
    if (painted) result.painted = painted_faces(*painted, result.blade.levels.front().mesh);
    result.steps.push_back(label_step(result));
    result.steps.push_back(prepare_step(result, prepare));
}

ScanRecord record_of(const ImportedScan& scan) {
    ScanRecord record;
    record.mm_per_unit = scan.mm_per_unit;
    record.unit_how = scan.unit_text;
    record.steps = scan.steps;
    record.inferred = scan.inferred;
    for (const ScanMeasure& m : scan.analysis.measures) {
        RecordDimension d{m.name, m.value, {}, m.unit, m.note};
        if (m.sigma > 0) d.sigma = m.sigma;
        record.dimensions.push_back(std::move(d));
    }
    return record;
}

std::string measure_label(std::string_view name) {
    std::string label(name.ends_with("_mm") ? name.substr(0, name.size() - 3) : name);
    std::replace(label.begin(), label.end(), '_', ' ');
    if (!label.empty() && label[0] >= 'a' && label[0] <= 'z')
        label[0] = static_cast<char>(label[0] - 'a' + 'A');
    return label;
}

std::map<std::string, std::vector<glm::dvec3>> drawn_measures(const ScannedStations& stations) {
    std::map<std::string, std::vector<glm::dvec3>> lines;
    const std::vector<Station>& all = stations.stations;
    if (all.size() < 2) return lines;
    const auto nearest = [&](double s_mm) -> const Station& {
        return *std::min_element(all.begin(), all.end(), [&](const Station& a, const Station& b) {
            return std::abs(a.s_mm - s_mm) < std::abs(b.s_mm - s_mm);
        });
    };
    const glm::dvec3 tip = all.back().ridge_mm;
    const glm::dvec3 machi = nearest(0).ridge_mm;
    lines["nagasa_mm"] = {machi, tip};
    if (stations.nakago_mm > 0) lines["nakago_mm"] = {all.front().ridge_mm, machi};
    const glm::dvec3 chord = tip - machi;
    const double length = glm::length(chord);
    if (!(length > 0)) return lines;
    double deepest = 0;
    for (const Station& s : all) {
        if (s.s_mm < 0) continue;
        const glm::dvec3 foot =
            machi + chord * (glm::dot(s.ridge_mm - machi, chord) / length / length);
        const double depth = glm::distance(foot, s.ridge_mm);
        if (depth <= deepest) continue;
        deepest = depth;
        lines["sori_mm"] = {foot, s.ridge_mm};
    }
    const auto across = [&](const Station& s, const char* haba, const char* kasane) {
        const glm::dvec3 out = glm::cross(s.along, s.across);
        std::array<glm::dvec3, 2> ends{};
        glm::dvec3 edge(0);
        for (const std::size_t side : {0U, 1U}) {
            const std::vector<glm::dvec2>& outline = s.side[side].outline_mm;
            if (outline.empty()) return;
            const glm::dvec2 most = *std::max_element(
                outline.begin(), outline.end(),
                [](const glm::dvec2& a, const glm::dvec2& b) { return a.y < b.y; });
            ends[side] = s.ridge_mm + s.across * most.x + out * (side == 0 ? most.y : -most.y);
            edge += 0.5 * (s.ridge_mm + s.across * outline.back().x);
        }
        lines[haba] = {s.ridge_mm, edge};
        lines[kasane] = {ends[0], ends[1]};
    };
    across(nearest(0), "motohaba_mm", "motokasane_mm");
    if (stations.yokote_s_mm < stations.nagasa_arc_mm) {
        const Station& yokote = nearest(stations.yokote_s_mm);
        across(yokote, "sakihaba_mm", "sakikasane_mm");
        lines["kissaki_mm"] = {yokote.ridge_mm, tip};
    }
    return lines;
}

}  // namespace togishi
