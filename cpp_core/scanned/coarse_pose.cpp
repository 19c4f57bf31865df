#include "scanned/coarse_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/order_statistics.hpp"
#include "base/text.hpp"
#include "scanned/smooth_curve.hpp"

namespace togishi {
namespace {

constexpr double bin_mm = 1;
constexpr double samples_wanted = 250000;

// Eigenvectors of a symmetric matrix as columns, largest eigenvalue first (Jacobi rotations).
glm::dmat3 principal_axes(glm::dmat3 a) {
    glm::dmat3 v(1);
    for (int sweep = 0; sweep < 30; ++sweep) {
        for (const auto& [p, q] : std::array<std::array<int, 2>, 3>{{{0, 1}, {0, 2}, {1, 2}}}) {
            if (std::abs(a[p][q]) < 1e-14 * (std::abs(a[p][p]) + std::abs(a[q][q]))) continue;
            const double theta = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
            const double c = std::cos(theta);
            const double s = std::sin(theta);
            glm::dmat3 j(1);
            j[p][p] = c;
            j[q][q] = c;
            j[q][p] = s;  // column q, row p
            j[p][q] = -s;
            a = glm::transpose(j) * a * j;
            v = v * j;
        }
    }
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int i, int k) { return a[i][i] > a[k][k]; });
    return {v[order[0]], v[order[1]], v[order[2]]};
}

struct Cloud {
    std::vector<glm::dvec3> points;
    glm::dvec3 middle{0};
    glm::dmat3 axes{1};
};

Cloud make_cloud(const TriangleMesh& mesh, const MeshPieces& pieces, std::span<const char> body,
                 double count) {
    Cloud cloud;
    for (const SurfaceSample& s : sample_surface(mesh, pieces, body, count))
        cloud.points.push_back(sample_position(mesh, s));
    for (const glm::dvec3& p : cloud.points) cloud.middle += p;
    cloud.middle /= std::max<double>(1, static_cast<double>(cloud.points.size()));
    glm::dmat3 spread(0);
    for (const glm::dvec3& p : cloud.points)
        spread += glm::outerProduct(p - cloud.middle, p - cloud.middle);
    cloud.axes = principal_axes(spread);
    return cloud;
}

double range_across(std::vector<double>& y) {
    return y.size() < 4 ? 0 : quantile(y, 0.97) - quantile(y, 0.03);
}

std::vector<LengthBin> make_bins(const std::vector<glm::dvec3>& points) {
    double low = 1e300;
    double high = -1e300;
    for (const glm::dvec3& p : points) {
        low = std::min(low, p.x);
        high = std::max(high, p.x);
    }
    const auto count = static_cast<std::size_t>((high - low) / bin_mm) + 1;
    std::vector<std::vector<std::uint32_t>> members(count);
    for (std::size_t i = 0; i < points.size(); ++i) {
        members[static_cast<std::size_t>((points[i].x - low) / bin_mm)].push_back(
            static_cast<std::uint32_t>(i));
    }
    std::vector<LengthBin> bins(count);
    std::vector<double> all;
    std::vector<double> back;
    std::vector<double> edge;
    for (std::size_t b = 0; b < count; ++b) {
        LengthBin& bin = bins[b];
        bin.x = low + (static_cast<double>(b) + 0.5) * bin_mm;
        bin.samples = members[b].size();
        if (bin.samples < 4) continue;
        all.clear();
        for (const std::uint32_t i : members[b]) all.push_back(points[i].z);
        bin.back_z = quantile(all, 0.995);
        bin.edge_z = quantile(all, 0.005);
        all.clear();
        back.clear();
        edge.clear();
        const double band = bin.width() / 8;
        for (const std::uint32_t i : members[b]) {
            all.push_back(points[i].y);
            if (points[i].z > bin.back_z - band) back.push_back(points[i].y);
            if (points[i].z < bin.edge_z + band) edge.push_back(points[i].y);
        }
        bin.thickness = range_across(all);
        bin.back_thickness = range_across(back);
        bin.edge_thickness = range_across(edge);
    }
    return bins;
}

// A collar stands out over the blade's even thickness.
void find_fittings(std::vector<LengthBin>& bins) {
    std::vector<CurveSample> samples;
    for (const LengthBin& bin : bins) {
        if (bin.samples >= 4) samples.push_back({bin.x, bin.thickness, 1});
    }
    if (samples.size() < 12) return;
    const double from = samples.front().x;
    const double to = samples.back().x;
    const SmoothCurve even = SmoothCurve::fit(samples, from, to, (to - from) / 4);
    const double limit = std::max(0.9, 4 * even.residual());
    std::vector<char> thick(bins.size(), 0);
    for (std::size_t b = 0; b < bins.size(); ++b)
        thick[b] = bins[b].thickness > even.at(bins[b].x) + limit ? 1 : 0;
    // It begins and ends with a step; a blade that is only unevenly thick does not.
    auto middle_of = [&](std::ptrdiff_t first, std::ptrdiff_t end) {
        std::vector<double> values;
        for (std::ptrdiff_t b = std::max<std::ptrdiff_t>(0, first);
             b < std::min(end, static_cast<std::ptrdiff_t>(bins.size())); ++b) {
            const LengthBin& bin = bins[static_cast<std::size_t>(b)];
            if (bin.samples >= 4) values.push_back(bin.thickness);
        }
        return values.empty() ? -1 : quantile(values, 0.5);
    };
    for (std::size_t b = 0; b < bins.size();) {
        if (thick[b] == 0) {
            ++b;
            continue;
        }
        std::size_t e = b;
        while (e < bins.size() && thick[e] != 0) ++e;
        const auto first = static_cast<std::ptrdiff_t>(b);
        const auto end = static_cast<std::ptrdiff_t>(e);
        const double inside = std::min(middle_of(first, first + 4), middle_of(end - 4, end));
        const double outside =
            std::max(middle_of(first - 7, first - 2), middle_of(end + 2, end + 7));
        if (inside > outside + 0.6 * limit) {
            for (std::size_t k = b == 0 ? 0 : b - 1; k < std::min(bins.size(), e + 1); ++k)
                bins[k].fitting = true;
        }
        b = e;
    }
}

double median_of(const std::vector<LengthBin>& bins, double LengthBin::*member, double from,
                 double to) {
    std::vector<double> values;
    for (std::size_t b = 0; b < bins.size(); ++b) {
        const double share = static_cast<double>(b) / static_cast<double>(bins.size());
        if (share < from || share > to || bins[b].fitting || bins[b].samples < 4) continue;
        values.push_back(bins[b].*member);
    }
    return quantile(values, 0.5);
}

struct Machi {
    double score = 0;
    double x = 0;
    double low_x = 0, high_x = 0;  // it lies between these, of which more is to be seen
};

// The step where the tang begins: the blade ahead is wider, and its edge side thin. `bins` run from
// the supposed tang on.
Machi find_machi(const std::vector<LengthBin>& bins) {
    constexpr int reach = 6;
    constexpr int search = 45;
    Machi best;
    const auto n = static_cast<int>(bins.size());
    const double thickness = std::max(0.5, median_of(bins, &LengthBin::thickness, 0.2, 0.8));
    std::vector<double> widths;
    widths.reserve(bins.size());
    for (const LengthBin& bin : bins) {
        if (!bin.fitting && bin.samples >= 4) widths.push_back(bin.width());
    }
    const double width = std::max(1.0, quantile(widths, 0.5));
    auto collect = [&](int start, int direction, std::vector<double>& w, std::vector<double>& e,
                       int& nearest) {
        for (int k = start; k >= 0 && k < n && std::abs(k - start) < search; k += direction) {
            const LengthBin& bin = bins[static_cast<std::size_t>(k)];
            if (bin.fitting || bin.samples < 4) continue;
            if (w.empty()) nearest = k;
            w.push_back(bin.width());
            e.push_back(bin.edge_thickness);
            if (static_cast<int>(w.size()) == reach) return;
        }
    };
    for (int i = std::max(reach, n / 25); i < 0.48 * n; ++i) {
        std::array<std::vector<double>, 2> w;
        std::array<std::vector<double>, 2> e;
        std::array<int, 2> nearest{i, i};
        collect(i - 2, -1, w[0], e[0], nearest[0]);
        collect(i + 1, 1, w[1], e[1], nearest[1]);
        if (w[0].size() < reach || w[1].size() < 2) continue;
        const double wider = (quantile(w[1], 0.5) - quantile(w[0], 0.5)) / width;
        const double thinner = (quantile(e[0], 0.5) - quantile(e[1], 0.5)) / thickness;
        if (wider < 0.03 || thinner < 0.06) continue;
        const double score = std::min(wider, 0.3) + std::min(thinner, 0.5);
        if (score > best.score)
            best = {score, 0, bins[static_cast<std::size_t>(nearest[0])].x,
                    bins[static_cast<std::size_t>(nearest[1])].x};
    }
    best.x = 0.5 * (best.low_x + best.high_x);
    // Under a fitting it is rarely in the middle: the habaki sits on it.
    for (const LengthBin& bin : bins) {
        if (!bin.fitting || bin.x < best.low_x || bin.x > best.high_x) continue;
        best.x = std::min(best.x, bin.x);
        break;
    }
    return best;
}

std::vector<LengthBin> reversed(const std::vector<LengthBin>& bins) {
    std::vector<LengthBin> other(bins.rbegin(), bins.rend());
    for (LengthBin& bin : other) bin.x = -bin.x;
    return other;
}

// Which pieces lie in line with the largest: parts of the same blade and fittings on it.
std::vector<char> find_body(const TriangleMesh& mesh, const MeshPieces& pieces) {
    std::vector<char> body(pieces.pieces.size(), 0);
    if (pieces.pieces.empty()) return body;
    body[0] = 1;
    if (pieces.pieces.size() == 1) return body;
    const Cloud cloud = make_cloud(mesh, pieces, body, 40000);
    const glm::dmat3 turn = glm::transpose(cloud.axes);
    std::vector<CurveSample> line;
    std::vector<double> y;
    std::vector<double> z;
    line.reserve(cloud.points.size());
    y.reserve(cloud.points.size());
    z.reserve(cloud.points.size());
    double low = 1e300;
    double high = -1e300;
    for (const glm::dvec3& p : cloud.points) {
        const glm::dvec3 q = turn * (p - cloud.middle);
        line.push_back({q.x, q.y, 1});
        y.push_back(q.z);
        low = std::min(low, q.x);
        high = std::max(high, q.x);
    }
    const SmoothCurve centre = SmoothCurve::fit(line, low, high, high - low);
    for (const CurveSample& s : line) z.push_back(std::abs(s.value - centre.at(s.x)));
    const double thickness = quantile(y, 0.98) - quantile(y, 0.02);
    const double half_width = quantile(z, 0.98);

    std::vector<glm::dvec3> lowest(pieces.pieces.size(), glm::dvec3(1e300));
    std::vector<glm::dvec3> highest(pieces.pieces.size(), glm::dvec3(-1e300));
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
        const std::uint32_t piece = pieces.of[f];
        if (piece == 0) continue;
        for (const std::uint32_t v : mesh.triangles[f]) {
            glm::dvec3 q = turn * (glm::dvec3(mesh.positions[v]) - cloud.middle);
            q.y -= centre.at(q.x);
            lowest[piece] = glm::min(lowest[piece], q);
            highest[piece] = glm::max(highest[piece], q);
        }
    }
    for (std::size_t i = 1; i < body.size(); ++i) {
        // Beyond the largest piece's ends its curve is known the less the farther.
        const double beyond = std::max({0.0, low - lowest[i].x, highest[i].x - high});
        const double reach = 1.4 * half_width + 6 + 0.12 * beyond;
        body[i] = std::max(-lowest[i].z, highest[i].z) < 1.3 * thickness &&
                  std::max(-lowest[i].y, highest[i].y) < reach;
    }
    return body;
}

// The user's machi in place of the one that was found. So near the scan's beginning that nothing
// can be told of a tang, there is none.
void take_given_machi(const glm::dvec3& machi_mm, CoarsePose& pose) {
    constexpr double least_tang_mm = 10;
    const double begin = pose.bins.front().x - 0.5 * bin_mm;
    const double x = (pose.rotation * (machi_mm - pose.origin)).x;
    const double behind_tip = pose.bins.back().x + 0.5 * bin_mm - x;
    if (!(x > begin - least_tang_mm && behind_tip > 40)) {
        throw InputError(
            "scan", "machi", whole_number(behind_tip) + " mm behind the tip",
            "a place on the blade: 40 to " + whole_number(pose.length_mm) + " mm behind it");
    }
    pose.tang = x > begin + least_tang_mm;
    pose.machi_x = pose.tang ? x : begin;
}

}  // namespace

std::vector<LengthBin> find_length_bins(const std::vector<glm::dvec3>& points) {
    if (points.empty()) return {};
    std::vector<LengthBin> bins = make_bins(points);
    find_fittings(bins);
    return bins;
}

CoarsePose find_coarse_pose(const TriangleMesh& mesh, const MeshPieces& pieces,
                            const PoseCorrection& correction) {
    CoarsePose pose;
    pose.body = find_body(mesh, pieces);
    Cloud cloud = make_cloud(mesh, pieces, pose.body, samples_wanted);
    if (cloud.points.size() < 100) return pose;

    // x along, z across in the blade's plane, y out of it.
    glm::dvec3 x = cloud.axes[0];
    glm::dvec3 z = cloud.axes[1];
    auto turned = [&] {
        return glm::transpose(glm::dmat3(x, glm::normalize(glm::cross(z, x)), z));
    };
    auto bins_now = [&] {
        const glm::dmat3 turn = turned();
        std::vector<glm::dvec3> points;
        points.reserve(cloud.points.size());
        for (const glm::dvec3& p : cloud.points) points.push_back(turn * (p - cloud.middle));
        return find_length_bins(points);
    };
    std::vector<LengthBin> bins = bins_now();
    double edge = median_of(bins, &LengthBin::edge_thickness, 0.3, 0.8);
    double back = median_of(bins, &LengthBin::back_thickness, 0.3, 0.8);
    const bool upside_down = edge > back;
    if (upside_down != correction.swap_edge_and_back) {
        z = -z;
        bins = bins_now();
        std::swap(edge, back);
    }
    pose.edge_over_back = edge / std::max(back, 1e-6);

    const double thickness = std::max(0.1, median_of(bins, &LengthBin::thickness, 0.2, 0.8));
    // A blade runs out to a point; its other end, tang or break, keeps its thickness.
    auto end_thickness = [&](double from, double to) {
        return median_of(bins, &LengthBin::thickness, from, to);
    };
    const double share = std::max(0.012, 4.0 / static_cast<double>(bins.size()));
    const double low_end = end_thickness(0, share);
    const double high_end = end_thickness(1 - share, 1);
    const double low_blunt = median_of(bins, &LengthBin::edge_thickness, 0.03, 0.12);
    const double high_blunt = median_of(bins, &LengthBin::edge_thickness, 0.88, 0.97);
    const Machi low_machi = find_machi(bins);
    const Machi high_machi = find_machi(reversed(bins));
    const double forward = (low_end - high_end + low_blunt - high_blunt) / thickness +
                           low_machi.score - high_machi.score;
    pose.end_certainty = std::min(1.0, std::abs(forward));
    Machi machi = low_machi;
    double last = high_end;
    if ((forward < 0) != correction.swap_ends) {
        x = -x;
        bins = bins_now();
        machi = high_machi;
        last = low_end;
    }
    pose.point = last < 0.6 * thickness;
    pose.tang = machi.score > 0.25;
    pose.machi_x = pose.tang ? machi.x : bins.front().x;
    pose.rotation = turned();
    pose.origin = mesh.origin + cloud.middle;
    pose.bins = std::move(bins);
    pose.length_mm = pose.bins.back().x - pose.bins.front().x + bin_mm;
    if (correction.machi_mm) take_given_machi(*correction.machi_mm, pose);
    return pose;
}

}  // namespace togishi
