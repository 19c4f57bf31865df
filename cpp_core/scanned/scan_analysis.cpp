#include "scanned/scan_analysis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/parallel.hpp"
#include "base/random_normal.hpp"
#include "base/text.hpp"
#include "scanned/blade_measures.hpp"
#include "scanned/fit_stations.hpp"
#include "scanned/taken_triangles.hpp"

namespace togishi {
namespace {

// Samples where the blade changes within a millimetre, and where the yokote is looked for.
constexpr double dense_per_mm2 = 25;
constexpr double point_per_mm2 = 10;

// Three numbers of a normal distribution, always the same for one vertex of one replicate.
glm::dvec3 vertex_noise(std::uint64_t vertex, std::uint64_t replicate) {
    RandomNormal random(vertex * 0x9e3779b97f4a7c15U ^ (replicate + 1) * 0xd1b54a32d192ed03U);
    const double x = random.normal();
    const double y = random.normal();
    return {x, y, random.normal()};
}

struct Samples {
    std::vector<SurfaceSample> samples;
    glm::dmat3 rotation{1};
    glm::dvec3 origin{0};

    [[nodiscard]] std::vector<ScanPoint> points(const TriangleMesh& mesh) const {
        std::vector<ScanPoint> result;
        result.reserve(samples.size());
        const glm::dvec3 shift = mesh.origin - origin;
        for (const SurfaceSample& s : samples)
            result.push_back({rotation * (sample_position(mesh, s) + shift), true});
        // Which way the surface faces about each vertex, by the triangles there.
        const glm::dvec3 y = glm::transpose(rotation)[1];
        std::vector<float> facing(mesh.positions.size(), 0);
        for (const Triangle& t : mesh.triangles) {
            const glm::dvec3 a(mesh.positions[t[0]]);
            const auto face =
                static_cast<float>(glm::dot(y, glm::cross(glm::dvec3(mesh.positions[t[1]]) - a,
                                                          glm::dvec3(mesh.positions[t[2]]) - a)));
            for (const std::uint32_t v : t) facing[v] += face;
        }
        std::size_t agree = 0;
        for (std::size_t i = 0; i < result.size(); ++i) {
            const Triangle& t = mesh.triangles[samples[i].triangle];
            result[i].omote = facing[t[0]] + facing[t[1]] + facing[t[2]] > 0;
            agree += result[i].omote == (result[i].position_mm.y > 0) ? 1 : 0;
        }
        const double share = static_cast<double>(agree) / static_cast<double>(result.size());
        for (ScanPoint& p : result) {
            // Inside out; or facing neither way, where only the place tells.
            if (share < 0.2) p.omote = !p.omote;
            if (share >= 0.2 && share <= 0.8) p.omote = p.position_mm.y > 0;
        }
        return result;
    }
    /// The scan as it could have come out as well.
    [[nodiscard]] std::vector<ScanPoint> disturbed(const TriangleMesh& mesh,
                                                   const std::vector<ScanPoint>& points,
                                                   double noise_mm, std::uint64_t replicate) const {
        std::vector<ScanPoint> result = points;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const SurfaceSample& s = samples[i];
            const Triangle& t = mesh.triangles[s.triangle];
            const double b = s.weight[0];
            const double c = s.weight[1];
            result[i].position_mm +=
                noise_mm * ((1 - b - c) * vertex_noise(t[0], replicate) +
                            b * vertex_noise(t[1], replicate) + c * vertex_noise(t[2], replicate));
        }
        return result;
    }
    /// By how much a sample averages the noise of its triangle's corners.
    [[nodiscard]] double calm() const {
        double sum = 0;
        for (const SurfaceSample& s : samples) {
            const double b = s.weight[0];
            const double c = s.weight[1];
            sum += (1 - b - c) * (1 - b - c) + b * b + c * c;
        }
        return std::sqrt(sum / std::max<double>(1, static_cast<double>(samples.size())));
    }
};

// By how much more a fit's rest is than the noise that was added for a second one explains.
struct Inflation {
    double before = 0, more = 0;
    void add(double first, double second) {
        before += first * first;
        more += second * second - first * first;
    }
    [[nodiscard]] double factor() const {
        return more > 0 ? std::clamp(std::sqrt(before / more), 0.5, 3.0) : 1;
    }
};

}  // namespace

std::string_view verdict_name(ScanVerdict verdict) {
    switch (verdict) {
        case ScanVerdict::blade:
            return "blade";
        case ScanVerdict::part_of_blade:
            return "part_of_blade";
        case ScanVerdict::several_blades:
            return "several_blades";
        case ScanVerdict::mounted:
            return "mounted";
        case ScanVerdict::no_blade:
            break;
    }
    return "no_blade";
}

namespace {

/// Length, width and thickness of what lies along the rough pose.
struct Build {
    double length = 0, width = 0, thickness = 0;
    double widest = 0, thickest = 0;  // of single bins
    double longest_gap = 0;
    [[nodiscard]] std::string text() const { return size_in_mm(length, width, thickness); }
};

Build build_of(const CoarsePose& pose) {
    Build build;
    build.length = pose.length_mm;
    std::vector<double> widths;
    std::vector<double> thicknesses;
    double gap = 0;
    for (const LengthBin& bin : pose.bins) {
        gap = bin.samples < 4 ? gap + 1 : 0;
        build.longest_gap = std::max(build.longest_gap, gap);
        if (bin.samples < 4) continue;
        build.widest = std::max(build.widest, bin.width());
        build.thickest = std::max(build.thickest, bin.thickness);
        widths.push_back(bin.width());
        thicknesses.push_back(bin.thickness);
    }
    build.width = median(widths);
    build.thickness = median(thicknesses);
    return build;
}

// Of all of a sword's shapes: long against its width, an edge thinner than its back, flat.
bool has_edge(const CoarsePose& pose) {
    return pose.edge_over_back < 0.72;
}
bool is_long(const Build& build) {
    return build.length > 4 * build.width;
}
bool is_flat(const Build& build) {
    return build.thickness < 0.5 * build.width;
}

// Another blade beside the first: one of the larger pieces that are not on it.
std::size_t count_other_blades(const TriangleMesh& mesh, const MeshPieces& pieces,
                               const std::vector<char>& body) {
    std::size_t count = 0;
    const BladePose as_it_lies{glm::dmat3(1), mesh.origin};
    for (std::size_t i = 1; i < std::min<std::size_t>(pieces.pieces.size(), 12); ++i) {
        if (body[i] != 0 || pieces.pieces[i].area_mm2 < 0.15 * pieces.pieces[0].area_mm2) continue;
        TakenTriangles one(mesh, as_it_lies);
        for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
            if (pieces.of[f] == i) one.add(mesh.triangles[f]);
        }
        const CoarsePose pose = find_coarse_pose(one.mesh, find_pieces(one.mesh));
        const Build build = build_of(pose);
        if (!pose.bins.empty() && has_edge(pose) && is_long(build) && is_flat(build)) ++count;
    }
    return count;
}

// Whether it can be a blade at all; the text says what it looks like instead.
bool looks_like_blade(const CoarsePose& pose, const Build& build, ScanAnalysis& result) {
    result.verdict = ScanVerdict::no_blade;
    if (pose.bins.empty()) {
        result.text = "The scan has hardly any surface; no blade can be told.";
        return false;
    }
    const std::string seen = "The largest piece is " + build.text() + ". ";
    if (!is_long(build)) {
        result.text = seen + "No blade is that short for its width: is the scan of something else?";
        return false;
    }
    if (build.length < 60 || build.length > 2500) {
        result.text = seen + "Blades are 60 to 2500 mm long: is the unit right?";
        return false;
    }
    if (!has_edge(pose) || !is_flat(build)) {
        result.text =
            seen +
            (is_flat(build) ? "Both of its long sides are equally thick, so it has no edge. "
                            : "It is too thick for a blade. ") +
            "Is it a scabbard or a mounting? A sword has to be scanned drawn.";
        return false;
    }
    if (build.longest_gap > 15 && build.longest_gap > 0.02 * build.length) {
        result.verdict = ScanVerdict::part_of_blade;
        result.text =
            seen + "For " + whole_number(build.longest_gap) +
            " mm of its length nothing was scanned: is it broken, are these two things in "
            "a row, or is a part of the scan missing?";
        return false;
    }
    if (build.widest > 1.9 * build.width || build.thickest > 3 * build.thickness + 6) {
        result.verdict = ScanVerdict::mounted;
        result.text =
            seen + "In one place it is " + whole_number(std::max(build.widest, build.thickest)) +
            " mm across: a guard or a hilt? Only a bare blade can be measured; take the mounting "
            "off, or cut it off the mesh.";
        return false;
    }
    return true;
}

std::string_view mune_name(MuneType type) {
    for (const ChoiceField& choice : katana_choices()) {
        if (choice.key == "mune") return choice.names[static_cast<std::size_t>(type)];
    }
    return "";
}

void note(ScanAnalysis& result, std::string_view begins, const std::string& why, bool inferred) {
    for (ScanMeasure& m : result.measures) {
        if (!m.name.starts_with(begins)) continue;
        m.inferred = m.inferred || inferred;
        m.note = why;
    }
}
void infer(ScanAnalysis& result, std::string_view begins, const std::string& why) {
    note(result, begins, why, true);
}

constexpr std::array from_machi{"nagasa", "sori", "moto", "nakago", "mune_height"};

// What rests on the user's word.
void note_corrections(const PoseCorrection& correction, ScanAnalysis& result) {
    if (correction.machi_mm) {
        for (const char* name : from_machi)
            note(result, name, "from the machi that was given", false);
    }
    if (correction.kissaki_mm) {
        note(result, "saki", "at the yokote that was given", false);
        note(result, "kissaki", "as given", false);
    }
}

void check(const PoseCorrection& correction) {
    if (!correction.kissaki_mm) return;
    const double kissaki = *correction.kissaki_mm;
    if (!(kissaki == 0 || (kissaki >= 5 && kissaki <= 300))) {
        throw InputError("scan", "kissaki_mm", std::to_string(kissaki),
                         "0 (no yokote), or 5 to 300 mm");
    }
}

// What of it the scan really shows.
void judge(const BladeFit& fit, const CoarsePose& pose, ScanAnalysis& result) {
    result.verdict = ScanVerdict::blade;
    if (!fit.point) {
        result.verdict = ScanVerdict::part_of_blade;
        result.text =
            "The blade runs out to no point: it is broken, or the scan ends before it. "
            "Length and sori cannot be told; is the rest of it in another file?";
    } else if (!fit.tang && fit.given_machi) {
        result.text = "A blade without a tang. Lengths count from the machi that was given.";
    } else if (!fit.tang) {
        result.text =
            "A blade without a tang: no machi was found. Lengths count from where the scan "
            "begins; is that the machi?";
        for (const char* name : {"nagasa", "sori", "moto", "mune_height"})
            infer(result, name, "from where the scan begins: there is no machi");
    } else {
        result.text = "A blade with its tang.";
    }
    if (fit.tang && !fit.machi) {
        result.doubts.emplace_back(
            "The machi is hidden or worn: lengths count from about where it must be, within some "
            "millimetres.");
        for (const char* name : from_machi) infer(result, name, "the machi is hidden or worn");
    }
    if (fit.yokote_unsure) {
        result.doubts.emplace_back(
            fit.yokote
                ? "The yokote is not certain: the scan is too coarse or noisy to tell it from "
                  "a shinogi that only bends (shobu-zukuri). Is there one?"
                : "No yokote was found, but the scan is too coarse or noisy to exclude one. "
                  "Is it a shobu-zukuri?");
        for (const char* name : {"saki", "kissaki"})
            infer(result, name, "not certain: the scan is too coarse or noisy to tell a yokote");
    }
    if (!fit.fittings_s.empty()) {
        result.doubts.emplace_back(
            "A fitting covers part of the blade (the habaki?): what is under it is inferred.");
    }
    if (pose.end_certainty < 0.12)
        result.doubts.emplace_back("Tip and tang may be the other way round.");
    if (pose.edge_over_back > 0.6)
        result.doubts.emplace_back("Edge and back may be the other way round.");
}

}  // namespace

ScanAnalysis analyse_scan(const TriangleMesh& mesh, const MeshPieces& pieces,
                          const ScanAnalysisOptions& options) {
    check(options.correction);
    ScanAnalysis result;
    const CoarsePose pose = find_coarse_pose(mesh, pieces, options.correction);
    result.body = pose.body;
    const Build build = build_of(pose);
    if (!looks_like_blade(pose, build, result)) return result;
    const std::string lost =
        "The piece of " + build.text() +
        " is long and has an edge, but no cross-sections of a blade fit it: is "
        "it one, and is its surface whole?";

    double area = 0;
    for (std::size_t i = 0; i < pieces.pieces.size(); ++i) {
        if (pose.body[i] != 0) area += pieces.pieces[i].area_mm2;
    }
    Samples samples;
    samples.rotation = pose.rotation;
    samples.origin = pose.origin;
    const double tip_x = pose.bins.back().x + 0.5;
    const double begin_x = pose.bins.front().x - 0.5;
    const double usual = options.samples / std::max(area, 1.0);
    const glm::dvec3 shift = mesh.origin - pose.origin;
    samples.samples = sample_surface(mesh, pieces, pose.body, [&](const glm::dvec3& p) {
        const double x = (pose.rotation * (p + shift)).x;
        const bool dense = x > tip_x - 14 || std::abs(x - pose.machi_x) < 12 || x < begin_x + 3;
        if (dense) return std::max(usual, dense_per_mm2);
        return x > tip_x - 5 * build.width ? std::max(usual, point_per_mm2) : usual;
    });
    std::vector<ScanPoint> points = samples.points(mesh);
    BladeFit fit;
    fit.given_kissaki_mm = options.correction.kissaki_mm;
    const auto place_machi = [&] {
        if (options.correction.machi_mm)
            fit.given_machi = samples.rotation * (*options.correction.machi_mm - samples.origin);
    };
    place_machi();
    if (!begin_fit(points, pose, fit)) {
        result.text = lost;
        return result;
    }
    constexpr int passes = 3;
    for (int pass = 0; pass < passes; ++pass) {
        if (!improve_fit(points, fit)) {
            result.text = lost;
            return result;
        }
        if (pass + 1 == passes) break;
        // Turned about the long axis, so that mune and edge lie in one plane.
        const double angle = -std::atan(fit.turned_rad);
        const glm::dmat3 turn{{1, 0, 0},
                              {0, std::cos(angle), std::sin(angle)},
                              {0, -std::sin(angle), std::cos(angle)}};
        samples.rotation = turn * samples.rotation;
        place_machi();
        for (ScanPoint& p : points) p.position_mm = turn * p.position_mm;
    }
    result.noise_mm = fit.residual_mm / std::max(0.1, samples.calm());
    const auto found = measure_fit(fit);

    std::vector<std::map<std::string, FitMeasure>> again(
        static_cast<std::size_t>(std::max(0, options.replicates)));
    std::vector<double> residual(again.size(), 0);
    parallel_for(again.size(), 1, [&](std::size_t from, std::size_t to) {
        for (std::size_t r = from; r < to; ++r) {
            BladeFit other = fit;
            if (!improve_fit(samples.disturbed(mesh, points, result.noise_mm, r), other)) continue;
            residual[r] = other.residual_mm;
            for (const FitMeasure& m : measure_fit(other)) again[r][m.name] = m;
        }
    });
    // Cross-sections take up part of the noise that is near them: with the noise once more, the
    // rest tells how much.
    Inflation of_points;
    for (const double r : residual) of_points.add(fit.residual_mm, r);
    const double scale = of_points.factor();
    result.noise_mm *= scale;
    for (const FitMeasure& measure : found) {
        ScanMeasure& m = result.measures.emplace_back();
        m.name = measure.name;
        m.value = measure.value;
        m.unit = "mm";
        double sum = 0;
        double n = 0;
        double mean = 0;
        // What a line's sections scatter more than the noise lets them (facets, wear) counts too.
        Inflation of_line;
        for (const auto& r : again) {
            const auto other = r.find(m.name);
            if (other == r.end()) continue;
            mean += other->second.value;
            ++n;
            if (measure.scatter > 0) of_line.add(measure.scatter, other->second.scatter);
        }
        mean /= std::max(1.0, n);
        for (const auto& r : again) {
            const auto other = r.find(m.name);
            if (other != r.end())
                sum += (other->second.value - mean) * (other->second.value - mean);
        }
        if (n > 1) m.sigma = std::max(scale, of_line.factor()) * std::sqrt(sum / (n - 1));
        // Most of the scans that could have come out as well do not show it.
        if (!again.empty() && n < 0.7 * static_cast<double>(again.size())) {
            m.inferred = true;
            m.note = "not certain: the scan's noise hides it";
        }
    }
    const BladePose in_fit = pose_of_fit(fit);
    result.pose.rotation = in_fit.rotation * samples.rotation;
    result.pose.origin_mm = samples.origin + glm::transpose(samples.rotation) * in_fit.origin_mm;
    result.zukuri = !fit.ridge ? "hira" : fit.yokote ? "shinogi" : "shobu";
    result.mune_type = mune_name(fit.mune.type);
    for (const auto& [from, to] : fit.fittings_s)
        result.fittings_mm.emplace_back(from - fit.machi_s_mm, to - fit.machi_s_mm);
    for (int i = 0; i <= 20; ++i) {
        const BladeLines& lines = fit.lines;
        const double s = lines.from_s_mm + (lines.to_s_mm - lines.from_s_mm) * i / 20;
        TaperPoint& t = result.taper.emplace_back();
        t.s_mm = s - fit.machi_s_mm;
        t.width_mm = lines.edge_d.at(s);
        t.kasane_mm = 2 * lines.corner_y.at(s);
        if (!fit.ridge) continue;
        t.shinogi_haba_mm = lines.shinogi_d.at(s);
        t.shinogi_kasane_mm = 2 * lines.shinogi_y.at(s);
    }
    judge(fit, pose, result);
    note_corrections(options.correction, result);
    const std::size_t others = count_other_blades(mesh, pieces, pose.body);
    if (others > 0) {
        result.verdict = ScanVerdict::several_blades;
        result.text =
            "The scan shows " + std::to_string(others + 1) +
            " blades. The largest was measured: delete the others, or is it the wrong one?";
    }
    if (result.verdict == ScanVerdict::blade || result.verdict == ScanVerdict::several_blades)
        result.stations = stations_of_fit(fit, points);
    return result;
}

}  // namespace togishi
