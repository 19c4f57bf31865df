#include "scanned/settle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "mesh/closest_point.hpp"

namespace togishi {
namespace {

// Worse than any stretch: folded over in the chart; without area.
constexpr double folded = 100;
constexpr double no_area = 1000;
constexpr double least_area_mm2 = 1e-9;
// A vertex of one side lies at least so far from the edge line.
constexpr double inside_edge_mm = 0.03;
// So near to the tip all regions come to a point, which takes in any vertex.
constexpr double tip_mm = 1.5;
// The largest fan to the tip.
constexpr double most_tip_mm = 2.5;
// A cut at the machi leaves vertices so near to it.
constexpr double at_machi_mm = 0.01;
// What a change must better to be worth it.
constexpr double gain = 0.9;

bool of_blade(Part part) {
    return part != Part::nakago && part != Part::other;
}

class Settler {
  public:
    Settler(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
            const SettleOptions& options)
        : c_(mesh), chart_(chart), scan_(scan), o_(options), around_(triangles_around(mesh.mesh)) {
        alive_.assign(triangles().size(), 1);
        tried_.assign(triangles().size(), 0);
        bound_mm_.assign(options.vertex_error_mm.begin(), options.vertex_error_mm.end());
        bound_mm_.resize(around_.size(), static_cast<float>(options.error_mm));
        shift_mm_.assign(options.vertex_shift_mm.begin(), options.vertex_shift_mm.end());
        shift_mm_.resize(around_.size(), 0);
        place_vertices();
    }

    SettledCount run() {
        count_.stretched_mm2 = area(stretched());
        point_tip();
        for (int round = 0; round < o_.most_rounds; ++round) {
            behind_machi();
            const std::vector<std::uint32_t> bad = stretched();
            if (bad.empty()) break;
            if (move_all(bad) > 0) continue;
            std::size_t changed = 0;
            for (const std::uint32_t f : bad) {
                if (alive_[f] == 0 || tried_[f] != 0 || stretch_of(f) <= o_.most_stretch) continue;
                if (change(f)) ++changed;
            }
            if (changed == 0) break;
        }
        const std::vector<std::uint32_t> left = stretched();
        count_.left = left.size();
        count_.left_mm2 = area(left);
        drop_dead();
        return count_;
    }

  private:
    /// A vertex as it is or would be.
    struct Place {
        glm::dvec3 position;
        double s_mm, t_mm;
    };

    std::vector<Triangle>& triangles() { return c_.mesh.triangles; }
    [[nodiscard]] const std::vector<Triangle>& triangles() const { return c_.mesh.triangles; }

    void place_vertices() {
        const BladeFrame& frame = chart_.frame();
        const std::size_t n = c_.mesh.positions.size();
        now_.resize(n);
        settled_.resize(n);
        state_.assign(n, State::fixed);
        seam_.assign(n, 0);
        line_.assign(n, Line::kept);
        for (std::size_t v = 0; v < n; ++v) {
            now_[v] = {glm::dvec3(c_.mesh.positions[v]), double(c_.s_mm[v]), double(c_.t_mm[v])};
            settled_[v] = now_[v];
            bool omote = false, ura = false, blade = false, mune = false, shinogi_ji = false,
                 side = false;
            for (const std::uint32_t f : around_[v]) {
                (c_.region[f].omote() ? omote : ura) = true;
                const Part part = c_.region[f].part();
                if (!of_blade(part)) continue;
                blade = true;
                (part == Part::mune ? mune : part == Part::shinogi_ji ? shinogi_ji : side) = true;
            }
            seam_[v] = omote && ura ? 1 : 0;
            if (!blade || !(bound_mm_[v] > 0)) continue;
            const Sides sides{omote, ura};
            // The blade's own triangles neither reach into the nakago nor beyond the edge line.
            glm::dvec2 from(std::clamp(now_[v].s_mm, 0.0, frame.nagasa_mm), now_[v].t_mm);
            if (omote != ura) {
                const double within = on_blade(frame.edge_mm, from.x) - inside_edge_mm;
                from.y = std::min(from.y, std::max(within, 0.0));
            }
            from.y = in_strip(from, v);
            glm::dvec2 to = from;
            Line line = regions(static_cast<std::uint32_t>(v)).size() > 1 ? Line::kept : Line::none;
            if (omote && ura) {
                const glm::dvec2 edge = nearest_of(frame.edge_mm, from);
                line = from.y < glm::distance(from, edge) ? Line::ridge : Line::edge;
                to = line == Line::ridge ? glm::dvec2(from.x, 0) : edge;
            } else if (mune && (shinogi_ji || side)) {
                line = Line::mune;
                to = nearest_of(frame.mune_mm, from);
            } else if (shinogi_ji && side) {
                line = Line::shinogi;
                to = nearest_of(frame.shinogi_mm, from);
            }
            // Where lines meet a vertex holds them all.
            if (corner(static_cast<std::uint32_t>(v), line)) line = Line::kept;
            // Onto the ridge, or as near to it as the scan lets it.
            for (const double share : {1.0, 0.9, 0.75, 0.5, 0.25, 0.0}) {
                const Place place =
                    on_surface(glm::mix(from, to, share), sides, double(shift_mm_[v]));
                // The vertex is one of the scan's own. Drawn in from the edge it would lie on the
                // scan still, and the edge be lost.
                const bool inwards = seam_[v] != 0 && place.t_mm < now_[v].t_mm;
                if (glm::distance(place.position, now_[v].position) <= double(bound_mm_[v]) ||
                    (!inwards && near_scan(place.position, bound_mm_[v]))) {
                    settled_[v] = place;
                    state_[v] = State::movable;
                    if (share == 1 || line == Line::none) line_[v] = line;
                    break;
                }
                if (to == from) break;
            }
        }
    }

    /// A vertex of one strip's triangles alone lies on that strip, where noise has it a little
    /// beyond; labels painted by hand are left as they are.
    [[nodiscard]] double in_strip(const glm::dvec2& st, std::size_t v) const {
        const std::vector<std::uint8_t> own = regions(static_cast<std::uint32_t>(v));
        if (own.size() != 1) return st.y;
        const BladeFrame& frame = chart_.frame();
        const double mune = on_blade(frame.mune_mm, st.x);
        const double shinogi = on_blade(frame.shinogi_mm, st.x);
        const Part part = Region(own.front()).part();
        const double low = part == Part::mune ? 0 : part == Part::shinogi_ji ? mune : shinogi;
        const double high = part == Part::mune         ? mune
                            : part == Part::shinogi_ji ? shinogi
                                                       : on_blade(frame.edge_mm, st.x);
        const double margin = std::min(inside_edge_mm, 0.2 * std::max(high - low, 0.0));
        const double inside = std::clamp(st.y, low + margin, std::max(low, high) - margin);
        return std::abs(inside - st.y) <= double(bound_mm_[v]) + margin ? inside : st.y;
    }

    /// What a vertex may slide along; none: it is free on its strip; kept: it stays.
    enum class Line : std::uint8_t { none, ridge, edge, mune, shinogi, kept };

    /// Whether a vertex on a line also lies on a border across it.
    [[nodiscard]] bool corner(std::uint32_t v, Line line) const {
        return line != Line::none && regions(v).size() > 2;
    }
    [[nodiscard]] double on_line(Line line, double s) const {
        const BladeFrame& frame = chart_.frame();
        if (line == Line::edge) return on_blade(frame.edge_mm, s);
        if (line == Line::mune) return on_blade(frame.mune_mm, s);
        return line == Line::shinogi ? on_blade(frame.shinogi_mm, s) : 0;
    }

    struct Sides {
        bool omote, ura;
    };
    /// shift_mm: out of the surface, on one side; what both sides share is not shifted.
    [[nodiscard]] Place on_surface(const glm::dvec2& st, const Sides& sides,
                                   double shift_mm = 0) const {
        glm::dvec3 sum(0);
        if (sides.omote) sum += chart_.point(st.x, st.y, true);
        if (sides.ura) sum += chart_.point(st.x, st.y, false);
        if (sides.omote && sides.ura) {
            sum *= 0.5;
        } else if (shift_mm != 0) {
            sum += shift_mm * outwards(st, sides.omote);
        }
        return {sum, st.x, st.y};
    }
    /// Unit normal of the smooth surface.
    [[nodiscard]] glm::dvec3 outwards(const glm::dvec2& st, bool omote) const {
        constexpr double h = 0.05;
        const glm::dvec3 along =
            chart_.point(st.x + h, st.y, omote) - chart_.point(st.x - h, st.y, omote);
        const glm::dvec3 down = chart_.point(st.x, st.y + h, omote) -
                                chart_.point(st.x, std::max(0.0, st.y - h), omote);
        const glm::dvec3 out = glm::cross(along, down);
        const double length = glm::length(out);
        return length > 0 ? (omote ? out : -out) / length : glm::dvec3(0);
    }

    /// An outline curve, also at the machi, where its samples lead over to the nakago.
    [[nodiscard]] double on_blade(const std::vector<double>& curve, double s) const {
        const BladeFrame& frame = chart_.frame();
        const double step = frame.length_mm() / static_cast<double>(curve.size() - 1);
        return frame.at(curve, std::max(s, step));
    }
    /// The nearest (s, t) of an outline curve.
    [[nodiscard]] glm::dvec2 nearest_of(const std::vector<double>& curve, glm::dvec2 st) const {
        const BladeFrame& frame = chart_.frame();
        constexpr double h = 0.25;
        double s = st.x;
        for (int i = 0; i < 4; ++i) {
            const double ahead = std::min(s + h, frame.nagasa_mm);
            const double slope =
                (on_blade(curve, ahead) - on_blade(curve, s - h)) / (ahead - s + h);
            const double off = on_blade(curve, s) - st.y - slope * (s - st.x);
            s = std::clamp(st.x - slope * off / (1 + slope * slope), 0.0, frame.nagasa_mm);
        }
        return {s, on_blade(curve, s)};
    }

    [[nodiscard]] bool near_scan(const glm::dvec3& p, float bound) const {
        return scan_.nearest(glm::vec3(p), {.within = 1.01F * bound, .enough = bound}).distance <=
               bound;
    }
    /// A triangle between vertices that are near.
    [[nodiscard]] bool near_scan(const Triangle& t) const {
        const glm::dvec3& a = best(t[0]).position;
        const glm::dvec3& b = best(t[1]).position;
        const glm::dvec3& c = best(t[2]).position;
        const float bound = std::min({bound_mm_[t[0]], bound_mm_[t[1]], bound_mm_[t[2]]});
        return near_scan(0.5 * (a + b), bound) && near_scan(0.5 * (b + c), bound) &&
               near_scan(0.5 * (c + a), bound) && near_scan((a + b + c) / 3.0, bound);
    }

    [[nodiscard]] glm::dvec2 in_chart(const Place& p, bool omote) const {
        const double y = chart_.frame().chart_y_mm(p.s_mm, p.t_mm);
        return {chart_.frame().chart_x_mm(p.s_mm, p.t_mm), omote ? -y : y};
    }

    /// Of a triangle with these corners, in that region; 0 where it does not count.
    [[nodiscard]] double stretch(const std::array<Place, 3>& p, Region region) const {
        if (!of_blade(region.part())) return 0;
        std::array<glm::dvec2, 3> at{};
        for (std::size_t k = 0; k < 3; ++k) at[k] = in_chart(p[k], region.omote());
        const glm::dvec3 twice =
            glm::cross(p[1].position - p[0].position, p[2].position - p[0].position);
        if (!(glm::length(twice) > least_area_mm2)) return no_area;
        const glm::dvec2 e1 = at[1] - at[0];
        const glm::dvec2 e2 = at[2] - at[0];
        // The chart is mirrored against the surface.
        if (e1.x * e2.y - e1.y * e2.x >= 0) return folded;
        const glm::dvec2 values =
            chart_stretch(p[0].position, p[1].position, p[2].position, at[0], at[1], at[2]);
        return std::max(values.y - 1, 1 - values.x);
    }
    [[nodiscard]] double stretch_of(std::uint32_t f) const {
        const Triangle& t = triangles()[f];
        return stretch({now_[t[0]], now_[t[1]], now_[t[2]]}, c_.region[f]);
    }
    [[nodiscard]] const Place& best(std::uint32_t v) const {
        return state_[v] == State::movable ? settled_[v] : now_[v];
    }
    [[nodiscard]] double settled_stretch(const Triangle& t, Region region) const {
        return stretch({best(t[0]), best(t[1]), best(t[2])}, region);
    }

    [[nodiscard]] std::vector<std::uint32_t> stretched() const {
        std::vector<std::uint32_t> bad;
        for (std::uint32_t f = 0; f < triangles().size(); ++f) {
            if (alive_[f] != 0 && stretch_of(f) > o_.most_stretch) bad.push_back(f);
        }
        return bad;
    }

    [[nodiscard]] double area(const std::vector<std::uint32_t>& faces) const {
        double sum = 0;
        for (const std::uint32_t f : faces) {
            const Triangle& t = triangles()[f];
            const glm::dvec3& p = now_[t[0]].position;
            sum += 0.5 * glm::length(glm::cross(now_[t[1]].position - p, now_[t[2]].position - p));
        }
        return sum;
    }

    /// Slivers whose corners all lie on the machi or behind it are the nakago's.
    void behind_machi() {
        for (std::size_t f = 0; f < triangles().size(); ++f) {
            const Triangle& t = triangles()[f];
            const Region region = c_.region[f];
            if (!of_blade(region.part()) || !std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
                    return best(v).s_mm <= at_machi_mm;
                }))
                continue;
            const glm::dvec2 middle(0, (best(t[0]).t_mm + best(t[1]).t_mm + best(t[2]).t_mm) / 3);
            c_.region[f] = Region(Part::nakago, region.omote(), strip(middle));
        }
    }

    /// Triangles around a vertex are worth another try.
    void touch(std::uint32_t v) {
        for (const std::uint32_t f : around_[v]) tried_[f] = 0;
    }
    bool move(std::uint32_t v) {
        if (state_[v] != State::movable) return false;
        now_[v] = settled_[v];
        state_[v] = State::moved;
        touch(v);
        ++count_.moved;
        return true;
    }
    std::size_t move_all(const std::vector<std::uint32_t>& faces) {
        const std::size_t before = count_.moved;
        for (const std::uint32_t f : faces) {
            for (const std::uint32_t v : triangles()[f]) move(v);
        }
        return count_.moved - before;
    }

    /// The triangles at both ends of an edge.
    [[nodiscard]] std::vector<std::uint32_t> at_edge(std::uint32_t a, std::uint32_t b) const {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t f : around_[a]) {
            const Triangle& t = triangles()[f];
            if (std::find(t.begin(), t.end(), b) != t.end()) found.push_back(f);
        }
        return found;
    }
    [[nodiscard]] static std::uint32_t other_corner(const Triangle& t, std::uint32_t a,
                                                    std::uint32_t b) {
        for (const std::uint32_t v : t) {
            if (v != a && v != b) return v;
        }
        return t[0];
    }

    /// By how much a triangle is stretched too much, squared: one that is much too bad is worse
    /// than a few that nearly do.
    [[nodiscard]] double excess(double stretch) const {
        const double over = std::max(0.0, stretch - o_.most_stretch);
        return over * over;
    }
    [[nodiscard]] double excess(const Triangle& t, Region region) const {
        return excess(settled_stretch(t, region));
    }

    enum class Kind : std::uint8_t { flip, collapse, slide };
    struct Change {
        double gained = 0;  // excess that goes; 0: none
        Kind kind = Kind::flip;
        std::uint32_t a = 0, b = 0;  // the edge; collapsed: a goes to b; slid: a alone
        Place to{};                  // where a slides
    };

    /// The best flip or collapse of an edge of f or slide of a corner, if any betters it.
    bool change(std::uint32_t f) {
        const Triangle t = triangles()[f];
        Change found;
        const auto take = [&](const Change& c) {
            if (c.gained > found.gained) found = c;
        };
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k];
            const std::uint32_t b = t[(k + 1) % 3];
            take(flip(a, b, found.gained));
            take(collapse(a, b, found.gained));
            take(collapse(b, a, found.gained));
            take(slide(a, found.gained));
        }
        for (std::size_t k = 0; k < 3 && found.gained <= 0; ++k) {
            for (const std::uint32_t w : neighbours(t[k])) take(collapse(t[k], w, found.gained));
        }
        tried_[f] = 1;
        if (found.gained <= 0) return false;
        switch (found.kind) {
            case Kind::flip:
                do_flip(found.a, found.b);
                break;
            case Kind::collapse:
                do_collapse(found.a, found.b);
                break;
            case Kind::slide:
                do_slide(found.a, found.to);
                break;
        }
        return true;
    }

    [[nodiscard]] std::array<Triangle, 2> flipped(std::uint32_t f, std::uint32_t g, std::uint32_t a,
                                                  std::uint32_t b) const {
        const std::uint32_t c = other_corner(triangles()[f], a, b);
        const std::uint32_t d = other_corner(triangles()[g], a, b);
        // Wound as f is: f has a before b or b before a.
        const Triangle& t = triangles()[f];
        const auto at = static_cast<std::size_t>(std::find(t.begin(), t.end(), a) - t.begin());
        const bool forward = t[(at + 1) % 3] == b;
        if (forward) return {Triangle{a, d, c}, Triangle{d, b, c}};
        return {Triangle{b, d, c}, Triangle{d, a, c}};
    }

    /// No change where it gains no more than `least`: the scan, which takes long to ask, is asked
    /// last.
    [[nodiscard]] Change flip(std::uint32_t a, std::uint32_t b, double least) const {
        const std::vector<std::uint32_t> two = at_edge(a, b);
        if (two.size() != 2) return {};
        const std::uint32_t f = two[0];
        const std::uint32_t g = two[1];
        if (c_.region[f].id() != c_.region[g].id()) return {};
        const std::uint32_t c = other_corner(triangles()[f], a, b);
        const std::uint32_t d = other_corner(triangles()[g], a, b);
        if (c == d || !at_edge(c, d).empty()) return {};
        const double before =
            excess(triangles()[f], c_.region[f]) + excess(triangles()[g], c_.region[f]);
        double after = 0;
        for (const Triangle& t : flipped(f, g, a, b)) after += excess(t, c_.region[f]);
        if (!(after < gain * before) || before - after <= least) return {};
        const float bound = std::min({bound_mm_[a], bound_mm_[b], bound_mm_[c], bound_mm_[d]});
        if (between_edges(best(a).position, best(b).position, best(c).position, best(d).position) >
            double(bound))
            return {};
        for (const Triangle& t : flipped(f, g, a, b)) {
            if (!near_scan(t)) return {};
        }
        return {before - after, Kind::flip, a, b, {}};
    }

    /// From the middle of one diagonal to the other pair of triangles is no farther than to the
    /// other diagonal; both ways.
    static double between_edges(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                                const glm::dvec3& d) {
        double most = 0;
        auto nearest = [](const glm::dvec3& p, const glm::dvec3& x, const glm::dvec3& y,
                          const glm::dvec3& z) {
            const glm::vec3 to =
                closest_on(glm::vec3(0), glm::vec3(x - p), glm::vec3(y - p), glm::vec3(z - p))
                    .point;
            return double(glm::length(to));
        };
        for (const double share : {0.25, 0.5, 0.75}) {
            const glm::dvec3 p = glm::mix(a, b, share);
            most = std::max(most, std::min(nearest(p, a, c, d), nearest(p, b, c, d)));
            const glm::dvec3 q = glm::mix(c, d, share);
            most = std::max(most, std::min(nearest(q, a, b, c), nearest(q, a, b, d)));
        }
        return most;
    }

    /// Regions around a vertex, without repeats.
    [[nodiscard]] std::vector<std::uint8_t> regions(std::uint32_t v) const {
        std::vector<std::uint8_t> found;
        for (const std::uint32_t f : around_[v]) {
            const std::uint8_t id = c_.region[f].id();
            if (std::find(found.begin(), found.end(), id) == found.end()) found.push_back(id);
        }
        return found;
    }
    [[nodiscard]] std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
        std::vector<std::uint32_t> found;
        for (const std::uint32_t f : around_[v]) {
            for (const std::uint32_t w : triangles()[f]) {
                if (w != v) found.push_back(w);
            }
        }
        std::sort(found.begin(), found.end());
        return found;
    }

    [[nodiscard]] Change collapse(std::uint32_t a, std::uint32_t b, double least) const {
        const std::vector<std::uint32_t> two = at_edge(a, b);
        if (two.size() != 2) return {};
        const std::vector<std::uint8_t> own = regions(a);
        // A border's vertex goes along the border only, to one that bounds the same regions.
        if (seam_[a] != 0 && seam_[b] == 0) return {};
        const bool at_tip =
            std::min(now_[a].s_mm, now_[b].s_mm) > chart_.frame().nagasa_mm - tip_mm;
        if (own.size() > 1 && !at_tip) {
            if (c_.region[two[0]].id() == c_.region[two[1]].id()) return {};
            const std::vector<std::uint8_t> others = regions(b);
            for (const std::uint8_t id : own) {
                if (std::find(others.begin(), others.end(), id) == others.end()) return {};
            }
        }
        // Closed around a, and the two vertices have two neighbours in common.
        std::vector<std::uint32_t> ring = neighbours(a);
        if (ring.size() != 2 * around_[a].size()) return {};
        for (std::size_t i = 0; i + 1 < ring.size(); i += 2) {
            if (ring[i] != ring[i + 1]) return {};
        }
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        if (ring.size() == 3) {
            // What is left must not be there already, from behind.
            std::erase(ring, b);
            for (const std::uint32_t f : at_edge(ring[0], ring[1])) {
                const Triangle& t = triangles()[f];
                if (std::find(t.begin(), t.end(), b) != t.end()) return {};
            }
            ring = {ring[0], ring[1], b};
            std::sort(ring.begin(), ring.end());
        }
        std::vector<std::uint32_t> far = neighbours(b);
        far.erase(std::unique(far.begin(), far.end()), far.end());
        std::vector<std::uint32_t> common;
        std::set_intersection(ring.begin(), ring.end(), far.begin(), far.end(),
                              std::back_inserter(common));
        if (common.size() != 2) return {};

        double before = 0;
        double after = 0;
        double nearest = std::numeric_limits<double>::infinity();
        for (const std::uint32_t f : around_[a]) {
            Triangle t = triangles()[f];
            before += excess(t, c_.region[f]);
            if (std::find(t.begin(), t.end(), b) != t.end()) continue;
            const glm::dvec3 old_normal = normal(t);
            std::replace(t.begin(), t.end(), a, b);
            after += excess(t, c_.region[f]);
            // What the chart does not hold (nakago) is not folded over either.
            if (!of_blade(c_.region[f].part()) && glm::dot(old_normal, normal(t)) <= 0) return {};
            const glm::dvec3 p = best(a).position;
            const auto corner = [&](std::size_t k) { return glm::vec3(best(t[k]).position - p); };
            nearest = std::min(
                nearest, double(glm::length(
                             closest_on(glm::vec3(0), corner(0), corner(1), corner(2)).point)));
        }
        if (!(after < gain * before) || before - after <= least || nearest > double(bound_mm_[a]))
            return {};
        for (const std::uint32_t f : around_[a]) {
            Triangle t = triangles()[f];
            if (std::find(t.begin(), t.end(), b) != t.end()) continue;
            std::replace(t.begin(), t.end(), a, b);
            if (!near_scan(t)) return {};
        }
        return {before - after, Kind::collapse, a, b, {}};
    }
    [[nodiscard]] glm::dvec3 normal(const Triangle& t) const {
        return glm::cross(best(t[1]).position - best(t[0]).position,
                          best(t[2]).position - best(t[0]).position);
    }

    /// Closed chains of vertex to next vertex; none where one ends.
    static std::vector<std::vector<std::uint32_t>> loops_of(
        std::map<std::uint32_t, std::uint32_t> next) {
        std::vector<std::vector<std::uint32_t>> loops;
        while (!next.empty()) {
            std::vector<std::uint32_t>& loop = loops.emplace_back();
            const std::uint32_t first = next.begin()->first;
            std::uint32_t v = first;
            do {
                const auto to = next.find(v);
                if (to == next.end()) return {};
                loop.push_back(v);
                v = to->second;
                next.erase(to);
            } while (v != first);
        }
        return loops;
    }

    /// Of the blade's strips (mune, shinogi-ji, ji), between which its surface has ridges.
    [[nodiscard]] int strip(const glm::dvec2& st) const {
        const BladeFrame& frame = chart_.frame();
        return st.y < on_blade(frame.mune_mm, st.x)      ? 0
               : st.y < on_blade(frame.shinogi_mm, st.x) ? 1
                                                         : 2;
    }

    /// Places about a vertex, on its strip or along its line.
    [[nodiscard]] std::vector<glm::dvec2> about(std::uint32_t v) const {
        const BladeFrame& frame = chart_.frame();
        const glm::dvec2 here(best(v).s_mm, best(v).t_mm);
        glm::dvec2 middle(0);
        double reach = 0;
        double n = 0;
        for (const std::uint32_t w : neighbours(v)) {
            const glm::dvec2 there(best(w).s_mm, best(w).t_mm);
            middle += there;
            reach += glm::distance(here, there);
            ++n;
        }
        middle /= n;
        reach /= n;
        std::vector<glm::dvec2> places;
        auto add = [&](const glm::dvec2& st) {
            if (!(st.x > 0 && st.x < frame.nagasa_mm && st.y > 0)) return;
            if (st.y > on_blade(frame.edge_mm, st.x) - inside_edge_mm || strip(st) != strip(here))
                return;
            places.push_back(st);
        };
        if (line_[v] == Line::none) {
            add(middle);
            add(glm::mix(here, middle, 0.5));
        }
        for (const double share : {0.5, 0.25, 0.12, 0.06, 0.03}) {
            const double d = share * reach;
            if (line_[v] == Line::none) {
                const double diagonal = d * std::numbers::sqrt2 / 2;
                for (const glm::dvec2& by :
                     {glm::dvec2(d, 0), glm::dvec2(-d, 0), glm::dvec2(0, d), glm::dvec2(0, -d),
                      glm::dvec2(diagonal, diagonal), glm::dvec2(diagonal, -diagonal),
                      glm::dvec2(-diagonal, diagonal), glm::dvec2(-diagonal, -diagonal)})
                    add(here + by);
                continue;
            }
            for (const double s : {here.x - d, here.x + d}) {
                if (s > 0 && s < frame.nagasa_mm) places.emplace_back(s, on_line(line_[v], s));
            }
        }
        return places;
    }

    /// A vertex that is on the surface goes to another place of it, one between strips along the
    /// line.
    [[nodiscard]] Change slide(std::uint32_t v, double least) const {
        if (state_[v] == State::fixed || line_[v] == Line::kept) return {};
        double before = 0;
        Sides sides{false, false};
        for (const std::uint32_t f : around_[v]) {
            if (!of_blade(c_.region[f].part())) return {};
            (c_.region[f].omote() ? sides.omote : sides.ura) = true;
            before += excess(triangles()[f], c_.region[f]);
        }
        Change found;
        for (const glm::dvec2& st : about(v)) {
            const Place to = on_surface(st, sides, double(shift_mm_[v]));
            double after = 0;
            for (const std::uint32_t f : around_[v]) {
                std::array<Place, 3> p{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t w = triangles()[f][k];
                    p[k] = w == v ? to : best(w);
                }
                after += excess(stretch(p, c_.region[f]));
            }
            const double gained = before - after;
            if (!(after < gain * before) || gained <= std::max(least, found.gained)) continue;
            if (!near_scan_from(v, to)) continue;
            found = {gained, Kind::slide, v, v, to};
        }
        return found;
    }
    /// The triangles about v, were it there.
    [[nodiscard]] bool near_scan_from(std::uint32_t v, const Place& to) const {
        const float bound = bound_mm_[v];
        if (!near_scan(to.position, bound)) return false;
        return std::all_of(around_[v].begin(), around_[v].end(), [&](std::uint32_t f) {
            glm::dvec3 sum(0);
            for (const std::uint32_t w : triangles()[f]) {
                const glm::dvec3& p = w == v ? to.position : best(w).position;
                if (w != v && !near_scan(0.5 * (p + to.position), bound)) return false;
                sum += p;
            }
            return near_scan(sum / 3.0, bound);
        });
    }
    void do_slide(std::uint32_t v, const Place& to) {
        const std::vector<std::uint32_t> ring = neighbours(v);
        for (const std::uint32_t w : ring) move(w);
        move(v);
        now_[v] = to;
        touch(v);
        for (const std::uint32_t w : ring) touch(w);
        ++count_.slid;
    }

    struct FanTriangle {
        std::uint32_t face;
        Triangle triangle;
    };
    /// Where the tip's fan comes to its point: at the chart's tip, or towards the scan's farthest
    /// vertex there, so that neither the fan lies too far from the scan nor what it stands for from
    /// the fan. None where no such place is.
    std::optional<Place> place_of_tip(std::uint32_t at, const std::vector<std::uint32_t>& replaced,
                                      const std::vector<FanTriangle>& fan) {
        const glm::dvec2 end(chart_.frame().nagasa_mm, 0);
        const Place& far = now_[*std::max_element(
            replaced.begin(), replaced.end(),
            [&](std::uint32_t a, std::uint32_t b) { return now_[a].s_mm < now_[b].s_mm; })];
        const float bound = bound_mm_[at];
        const auto near_fan = [&](std::uint32_t v, float to_fan) {
            const glm::dvec3& p = now_[v].position;
            return std::any_of(fan.begin(), fan.end(), [&](const FanTriangle& one) {
                const auto corner = [&](std::size_t k) {
                    return glm::vec3(best(one.triangle[k]).position - p);
                };
                const ClosestPoint found =
                    closest_on(glm::vec3(0), corner(0), corner(1), corner(2));
                return glm::length(found.point) <= to_fan;
            });
        };
        const Place before = settled_[at];
        std::optional<Place> found;
        // The scan has points between those that the fan replaces: at first less is allowed.
        for (const float to_fan : {0.7F * bound, bound}) {
            for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                if (found) break;
                settled_[at] = on_surface(glm::mix(end, {far.s_mm, far.t_mm}, share), {true, true});
                if (near_scan(settled_[at].position, bound) &&
                    std::all_of(fan.begin(), fan.end(),
                                [&](const FanTriangle& one) { return near_scan(one.triangle); }) &&
                    std::all_of(replaced.begin(), replaced.end(),
                                [&](std::uint32_t v) { return near_fan(v, to_fan); }))
                    found = settled_[at];
            }
        }
        settled_[at] = before;
        return found;
    }
    struct TipFan {
        std::uint32_t at = 0;
        Place tip{};
        double worst = std::numeric_limits<double>::infinity();  // stretch of its triangles
        std::vector<FanTriangle> fan;
        std::vector<std::uint32_t> faces;  // that it stands for
        std::size_t vertices = 0;
    };

    /// The blade within some of these distances of the tip is hardly larger than the scan's noise:
    /// one fan, the largest that the chart does not stretch, else the one that it stretches least.
    void point_tip() {
        TipFan best_fan;
        for (double radius_mm = most_tip_mm; radius_mm > 0.2; radius_mm *= 0.8) {
            TipFan found = tip_within(radius_mm);
            if (found.worst < best_fan.worst) best_fan = std::move(found);
            if (best_fan.worst <= o_.most_stretch) break;
        }
        if (!best_fan.fan.empty()) do_tip(best_fan);
    }

    /// All vertices within a radius of the tip, and joined to it there, become the tip's own; none
    /// where that leaves no whole fan or lies too far from the scan.
    TipFan tip_within(double radius_mm) {
        const double end_mm = chart_.frame().nagasa_mm;
        const Place tip = on_surface({end_mm, 0}, {true, true});
        std::uint32_t at = 0;
        double nearest = radius_mm;
        for (std::uint32_t v = 0; v < now_.size(); ++v) {
            const double distance = glm::distance(now_[v].position, tip.position);
            if (seam_[v] == 0 || state_[v] != State::movable || distance >= nearest) continue;
            nearest = distance;
            at = v;
        }
        if (nearest >= radius_mm) return {};
        std::vector<std::uint8_t> within(now_.size(), 0);
        std::vector<std::uint32_t> found{at};
        within[at] = 1;
        std::vector<std::uint32_t> faces;
        std::vector<FanTriangle> fan;
        std::map<std::uint32_t, std::uint32_t> next;
        std::size_t looked_at = 0;
        double reach_mm = radius_mm;
        for (bool pinched = true; pinched;) {
            for (; looked_at < found.size(); ++looked_at) {
                for (const std::uint32_t f : around_[found[looked_at]]) {
                    faces.push_back(f);
                    for (const std::uint32_t v : triangles()[f]) {
                        if (within[v] != 0 ||
                            glm::distance(now_[v].position, tip.position) > reach_mm)
                            continue;
                        within[v] = 1;
                        found.push_back(v);
                    }
                }
            }
            std::sort(faces.begin(), faces.end());
            faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
            // What is left of them: one triangle to each edge of a closed loop. A vertex that the
            // loop passes twice lies in a pocket and belongs to the tip too.
            pinched = false;
            fan.clear();
            next.clear();
            for (const std::uint32_t f : faces) {
                Triangle t = triangles()[f];
                if (within[t[0]] + within[t[1]] + within[t[2]] != 1) continue;
                const std::size_t k = within[t[0]] != 0 ? 0U : within[t[1]] != 0 ? 1U : 2U;
                t = {at, t[(k + 1) % 3], t[(k + 2) % 3]};
                fan.push_back({f, t});
                if (next.emplace(t[1], t[2]).second) continue;
                if (glm::distance(now_[t[1]].position, tip.position) > 4 * most_tip_mm) return {};
                within[t[1]] = 1;
                found.push_back(t[1]);
                pinched = true;
                break;
            }
            reach_mm = 0;
            if (pinched) continue;
            // Of several loops the others lie around pockets.
            const std::vector<std::vector<std::uint32_t>> loops = loops_of(next);
            if (loops.empty()) return {};
            const auto longest =
                std::max_element(loops.begin(), loops.end(),
                                 [](const auto& a, const auto& b) { return a.size() < b.size(); });
            for (auto loop = loops.begin(); loop != loops.end(); ++loop) {
                if (loop == longest) continue;
                pinched = true;
                for (const std::uint32_t v : *loop) {
                    if (glm::distance(now_[v].position, tip.position) > 4 * most_tip_mm) return {};
                    within[v] = 1;
                    found.push_back(v);
                }
            }
        }
        if (fan.size() < 4) return {};
        const std::optional<Place> to = place_of_tip(at, found, fan);
        if (!to) return {};
        TipFan result{at, *to, 0, std::move(fan), std::move(faces), found.size()};
        const Place before = std::exchange(settled_[at], *to);
        for (const FanTriangle& one : result.fan) {
            result.worst =
                std::max(result.worst, settled_stretch(one.triangle, c_.region[one.face]));
        }
        settled_[at] = before;
        return result;
    }

    void do_tip(const TipFan& tip) {
        settled_[tip.at] = tip.tip;
        for (const std::uint32_t f : tip.faces) {
            for (const std::uint32_t w : triangles()[f]) std::erase(around_[w], f);
            alive_[f] = 0;
        }
        for (const FanTriangle& one : tip.fan) {
            triangles()[one.face] = one.triangle;
            alive_[one.face] = 1;
            for (const std::uint32_t w : one.triangle) around_[w].push_back(one.face);
        }
        for (const FanTriangle& one : tip.fan) {
            for (const std::uint32_t w : one.triangle) move(w);
        }
        line_[tip.at] = Line::kept;
        count_.collapsed += tip.vertices - 1;
    }

    void do_flip(std::uint32_t a, std::uint32_t b) {
        const std::vector<std::uint32_t> two = at_edge(a, b);
        const std::array<Triangle, 2> made = flipped(two[0], two[1], a, b);
        for (std::size_t i = 0; i < 2; ++i) {
            for (const std::uint32_t v : triangles()[two[i]]) std::erase(around_[v], two[i]);
        }
        for (std::size_t i = 0; i < 2; ++i) {
            triangles()[two[i]] = made[i];
            for (const std::uint32_t v : made[i]) {
                around_[v].push_back(two[i]);
                move(v);
            }
        }
        for (const Triangle& t : made) {
            for (const std::uint32_t v : t) touch(v);
        }
        ++count_.flipped;
    }

    void do_collapse(std::uint32_t a, std::uint32_t b) {
        const std::vector<std::uint32_t> faces = around_[a];
        for (const std::uint32_t f : faces) {
            Triangle& t = triangles()[f];
            if (std::find(t.begin(), t.end(), b) != t.end()) {
                for (const std::uint32_t v : t) {
                    if (v != a) std::erase(around_[v], f);
                }
                alive_[f] = 0;
                continue;
            }
            std::replace(t.begin(), t.end(), a, b);
            around_[b].push_back(f);
            for (const std::uint32_t v : t) move(v);
        }
        around_[a].clear();
        for (const std::uint32_t f : around_[b]) {
            for (const std::uint32_t v : triangles()[f]) touch(v);
        }
        ++count_.collapsed;
    }

    /// Triangles and vertices that are no more go; the rest keep their order.
    void drop_dead() {
        std::size_t kept = 0;
        for (std::size_t f = 0; f < triangles().size(); ++f) {
            if (alive_[f] == 0) continue;
            triangles()[kept] = triangles()[f];
            c_.region[kept] = c_.region[f];
            ++kept;
        }
        triangles().resize(kept);
        c_.region.resize(kept);
        std::vector<std::uint32_t> place(now_.size(), 0);
        std::size_t n = 0;
        for (std::size_t v = 0; v < now_.size(); ++v) {
            if (around_[v].empty()) continue;
            place[v] = static_cast<std::uint32_t>(n);
            c_.mesh.positions[n] =
                state_[v] == State::moved ? glm::vec3(now_[v].position) : c_.mesh.positions[v];
            if (!c_.mesh.colours.empty()) c_.mesh.colours[n] = c_.mesh.colours[v];
            c_.s_mm[n] = static_cast<float>(now_[v].s_mm);
            c_.t_mm[n] = static_cast<float>(now_[v].t_mm);
            c_.off_mm[n] = state_[v] == State::moved ? shift_mm_[v] : c_.off_mm[v];
            ++n;
        }
        c_.mesh.positions.resize(n);
        if (!c_.mesh.colours.empty()) c_.mesh.colours.resize(n);
        c_.s_mm.resize(n);
        c_.t_mm.resize(n);
        c_.off_mm.resize(n);
        for (Triangle& t : triangles()) {
            for (std::uint32_t& v : t) v = place[v];
        }
    }

    enum class State : std::uint8_t { fixed, movable, moved };

    ChartedMesh& c_;
    const ScannedChart& chart_;
    const SurfaceTree& scan_;
    const SettleOptions& o_;
    std::vector<std::vector<std::uint32_t>> around_;  // each vertex's triangles
    std::vector<std::uint8_t> alive_, seam_;
    std::vector<float> shift_mm_;
    std::vector<float> bound_mm_;      // how far from the scan what is about a vertex may lie
    std::vector<std::uint8_t> tried_;  // in vain, and nothing has changed around it since
    std::vector<Place> now_, settled_;
    std::vector<State> state_;
    std::vector<Line> line_;
    SettledCount count_;
};

}  // namespace

SettledCount settle(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
                    const SettleOptions& options) {
    return Settler(mesh, chart, scan, options).run();
}

}  // namespace togishi
