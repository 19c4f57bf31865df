#include "scanned/settle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
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
// Within this of the tip the blade is hardly larger than a scan's noise: one fan to the tip.
constexpr double tip_fan_mm = 0.8;
// What a change must better to be worth it.
constexpr double gain = 0.9;

bool of_blade(Part part) {
    return part != Part::nakago && part != Part::other;
}

class Settler {
  public:
    Settler(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
            const SettleOptions& options)
        : c_(mesh), chart_(chart), scan_(scan), o_(options), around_(mesh.mesh.positions.size()) {
        for (std::size_t f = 0; f < triangles().size(); ++f) {
            for (const std::uint32_t v : triangles()[f])
                around_[v].push_back(static_cast<std::uint32_t>(f));
        }
        alive_.assign(triangles().size(), 1);
        tried_.assign(triangles().size(), 0);
        place_vertices();
    }

    SettledCount run() {
        for (double radius_mm = tip_fan_mm; radius_mm > 0.2; radius_mm *= 0.7) {
            if (point_tip(radius_mm)) break;
        }
        for (int round = 0; round < o_.most_rounds; ++round) {
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
        count_.left = stretched().size();
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
            if (!blade) continue;
            const Sides sides{omote, ura};
            // The blade's own triangles neither reach into the nakago nor beyond the edge line.
            glm::dvec2 from(std::clamp(now_[v].s_mm, 0.0, frame.nagasa_mm), now_[v].t_mm);
            if (omote != ura) {
                const double within = frame.at(frame.edge_mm, from.x) - inside_edge_mm;
                from.y = std::min(from.y, std::max(within, 0.0));
            }
            glm::dvec2 to = from;
            if (omote && ura) {
                const glm::dvec2 edge = nearest_of(frame.edge_mm, from);
                to = from.y < glm::distance(from, edge) ? glm::dvec2(from.x, 0) : edge;
            } else if (mune && (shinogi_ji || side)) {
                to = nearest_of(frame.mune_mm, from);
            } else if (shinogi_ji && side) {
                to = nearest_of(frame.shinogi_mm, from);
            }
            // Onto the ridge, or as near to it as the scan lets it.
            for (const double share : {1.0, 0.9, 0.75, 0.5, 0.25, 0.0}) {
                const Place place = on_surface(glm::mix(from, to, share), sides);
                // The vertex is one of the scan's own.
                if (glm::distance(place.position, now_[v].position) <= o_.error_mm ||
                    near_scan(place.position)) {
                    settled_[v] = place;
                    state_[v] = State::movable;
                    break;
                }
                if (to == from) break;
            }
        }
    }

    struct Sides {
        bool omote, ura;
    };
    [[nodiscard]] Place on_surface(const glm::dvec2& st, const Sides& sides) const {
        glm::dvec3 sum(0);
        if (sides.omote) sum += chart_.point(st.x, st.y, true);
        if (sides.ura) sum += chart_.point(st.x, st.y, false);
        if (sides.omote && sides.ura) sum *= 0.5;
        return {sum, st.x, st.y};
    }

    /// The nearest (s, t) of an outline curve.
    [[nodiscard]] glm::dvec2 nearest_of(const std::vector<double>& curve, glm::dvec2 st) const {
        const BladeFrame& frame = chart_.frame();
        constexpr double h = 0.25;
        double s = st.x;
        for (int i = 0; i < 4; ++i) {
            const double ahead = std::min(s + h, frame.nagasa_mm);
            const double slope =
                (frame.at(curve, ahead) - frame.at(curve, s - h)) / (ahead - s + h);
            const double off = frame.at(curve, s) - st.y - slope * (s - st.x);
            s = std::clamp(st.x - slope * off / (1 + slope * slope), 0.0, frame.nagasa_mm);
        }
        return {s, frame.at(curve, s)};
    }

    [[nodiscard]] bool near_scan(const glm::dvec3& p) const {
        const auto bound = static_cast<float>(o_.error_mm);
        return scan_.nearest(glm::vec3(p), {.within = 1.01F * bound, .enough = bound}).distance <=
               bound;
    }
    /// A triangle between vertices that are near.
    [[nodiscard]] bool near_scan(const Triangle& t) const {
        const glm::dvec3& a = best(t[0]).position;
        const glm::dvec3& b = best(t[1]).position;
        const glm::dvec3& c = best(t[2]).position;
        return near_scan(0.5 * (a + b)) && near_scan(0.5 * (b + c)) && near_scan(0.5 * (c + a)) &&
               near_scan((a + b + c) / 3.0);
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

    /// By how much triangles are stretched too much, in all.
    [[nodiscard]] double excess(const Triangle& t, Region region) const {
        return std::max(0.0, settled_stretch(t, region) - o_.most_stretch);
    }

    struct Change {
        double gained = 0;  // excess that goes; 0: none
        bool flip = false;
        std::uint32_t a = 0, b = 0;  // the edge; collapsed: a goes to b
    };

    /// The best flip or collapse of an edge of f, if any betters it.
    bool change(std::uint32_t f) {
        const Triangle t = triangles()[f];
        Change found;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k];
            const std::uint32_t b = t[(k + 1) % 3];
            for (const Change& c : {flip(a, b, found.gained), collapse(a, b, found.gained),
                                    collapse(b, a, found.gained)}) {
                if (c.gained > found.gained) found = c;
            }
        }
        tried_[f] = 1;
        if (found.gained <= 0) return false;
        if (found.flip) {
            do_flip(found.a, found.b);
        } else {
            do_collapse(found.a, found.b);
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
        if (between_edges(best(a).position, best(b).position, best(c).position, best(d).position) >
            o_.error_mm)
            return {};
        for (const Triangle& t : flipped(f, g, a, b)) {
            if (!near_scan(t)) return {};
        }
        return {before - after, true, a, b};
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
        if (ring.size() < 4) return {};
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
        if (!(after < gain * before) || before - after <= least || nearest > o_.error_mm) return {};
        for (const std::uint32_t f : around_[a]) {
            Triangle t = triangles()[f];
            if (std::find(t.begin(), t.end(), b) != t.end()) continue;
            std::replace(t.begin(), t.end(), a, b);
            if (!near_scan(t)) return {};
        }
        return {before - after, false, a, b};
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

    /// All vertices within a radius of the tip, and joined to it there, become the tip's own; false
    /// where that leaves no whole fan or lies too far from the scan.
    bool point_tip(double radius_mm) {
        const double end_mm = chart_.frame().nagasa_mm;
        const Place tip = on_surface({end_mm, 0}, {true, true});
        if (!near_scan(tip.position)) return false;
        std::uint32_t at = 0;
        double nearest = radius_mm;
        for (std::uint32_t v = 0; v < now_.size(); ++v) {
            const double distance = glm::distance(now_[v].position, tip.position);
            if (seam_[v] == 0 || state_[v] != State::movable || distance >= nearest) continue;
            nearest = distance;
            at = v;
        }
        if (nearest >= radius_mm) return false;
        std::vector<std::uint8_t> within(now_.size(), 0);
        std::vector<std::uint32_t> found{at};
        within[at] = 1;
        std::vector<std::uint32_t> faces;
        struct Fan {
            std::uint32_t face;
            Triangle triangle;
        };
        std::vector<Fan> fan;
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
                if (glm::distance(now_[t[1]].position, tip.position) > 4 * tip_fan_mm) return false;
                within[t[1]] = 1;
                found.push_back(t[1]);
                pinched = true;
                break;
            }
            reach_mm = 0;
            if (pinched) continue;
            // Of several loops the others lie around pockets.
            const std::vector<std::vector<std::uint32_t>> loops = loops_of(next);
            if (loops.empty()) return false;
            const auto longest =
                std::max_element(loops.begin(), loops.end(),
                                 [](const auto& a, const auto& b) { return a.size() < b.size(); });
            for (auto loop = loops.begin(); loop != loops.end(); ++loop) {
                if (loop == longest) continue;
                pinched = true;
                for (const std::uint32_t v : *loop) {
                    if (glm::distance(now_[v].position, tip.position) > 4 * tip_fan_mm)
                        return false;
                    within[v] = 1;
                    found.push_back(v);
                }
            }
        }
        if (fan.size() < 4) return false;
        const Place before = settled_[at];
        settled_[at] = tip;
        for (const Fan& one : fan) {
            if (near_scan(one.triangle)) continue;
            settled_[at] = before;
            return false;
        }
        for (const std::uint32_t f : faces) {
            for (const std::uint32_t w : triangles()[f]) std::erase(around_[w], f);
            alive_[f] = 0;
        }
        for (const Fan& one : fan) {
            triangles()[one.face] = one.triangle;
            alive_[one.face] = 1;
            for (const std::uint32_t w : one.triangle) around_[w].push_back(one.face);
        }
        for (const Fan& one : fan) {
            for (const std::uint32_t w : one.triangle) move(w);
        }
        count_.collapsed += found.size() - 1;
        return true;
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
            c_.off_mm[n] = state_[v] == State::moved ? 0 : c_.off_mm[v];
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
    std::vector<std::uint8_t> tried_;  // in vain, and nothing has changed around it since
    std::vector<Place> now_, settled_;
    std::vector<State> state_;
    SettledCount count_;
};

}  // namespace

SettledCount settle(ChartedMesh& mesh, const ScannedChart& chart, const SurfaceTree& scan,
                    const SettleOptions& options) {
    return Settler(mesh, chart, scan, options).run();
}

}  // namespace togishi
