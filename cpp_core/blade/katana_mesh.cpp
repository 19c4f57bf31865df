#include "blade/katana_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "blade/katana_frame.hpp"
#include "blade/katana_shape.hpp"

namespace togishi {
namespace {

struct Node {
    Strip strip;
    double f;
};

// Nodes of a half cross-section, strip by strip; where strips meet there are two, one for each
// one's normal.
struct Columns {
    std::array<int, 6> cells{};         // per strip; 0 where the blade has no such strip
    std::array<int, 6> first_column{};  // vertex column of the strip's first node
    std::array<int, 6> first_node{};
    std::vector<Node> nodes;
    int last_column = 0;  // the edge line, or the middle of the nakago's foot
    int corner_column = 0;
    int edge_column = 0;
};

struct RowPlace {
    Stretch stretch;
    double q;
    int vertex_row;  // shared by the last row of one stretch and the first of the next
};

struct Corner {
    glm::dvec3 position_mm;
    glm::vec3 normal;
    glm::vec3 tangent;
    glm::vec2 uv;
    float s_mm;
    float t_mm;
};

int scaled(double count, double scale, int least) {
    return std::max(least, static_cast<int>(std::lround(count * scale)));
}

Columns make_columns(const KatanaShape& shape, double scale) {
    Columns c;
    const bool maru = shape.parameters().mune == MuneType::maru;
    auto set = [&](Strip strip, double count, int least) {
        c.cells[static_cast<std::size_t>(strip)] = scaled(count, scale, least);
    };
    if (shape.has(Strip::mune_top, Stretch::blade)) set(Strip::mune_top, 2, 1);
    set(Strip::mune_side, maru ? 10 : 3, maru ? 2 : 1);
    if (shape.has_shinogi()) set(Strip::shinogi_ji, 7, 1);
    set(Strip::ji, shape.has_shinogi() ? 16 : 21, 1);
    set(Strip::ha, 12, 1);
    // The nakago's end welds the foot to the mune, node by node.
    const int mune = c.cells[0] + c.cells[1];
    c.cells[static_cast<std::size_t>(Strip::foot)] = mune;

    // Where the mune's nodes lie on the end line; the foot's meet them there.
    std::vector<double> mune_y;
    mune_y.reserve(static_cast<std::size_t>(mune) + 1);
    const double top_share = c.cells[0] > 0 ? 0.4 : 0;
    for (int i = 0; i < c.cells[0]; ++i) mune_y.push_back(top_share * i / c.cells[0]);
    for (int i = 0; i <= c.cells[1]; ++i)
        mune_y.push_back(top_share + (1 - top_share) * i / c.cells[1]);

    int column = 0;
    for (const Strip strip : strips) {
        const auto k = static_cast<std::size_t>(strip);
        c.first_column[k] = column;
        c.first_node[k] = static_cast<int>(c.nodes.size());
        if (c.cells[k] == 0) continue;
        for (int i = 0; i <= c.cells[k]; ++i) {
            double f = static_cast<double>(i) / c.cells[k];
            if (strip == Strip::foot) f = 1 - mune_y[static_cast<std::size_t>(mune - i)];
            c.nodes.push_back({strip, f});
        }
        column += c.cells[k];
    }
    c.last_column = column;
    c.corner_column = mune;
    c.edge_column = c.first_column[static_cast<std::size_t>(Strip::foot)];
    return c;
}

// Replaces the nakago's rows (from `begin`) that pass the peg hole by closer ones, so that it is
// round.
void crowd_at_hole(std::vector<RowPlace>& rows, std::size_t begin, const KatanaParameters& p,
                   double scale) {
    const double centre = -p.mekugi_ana_from_machi_mm;
    const double room = 0.63 * p.mekugi_ana_mm;
    const int cells = 2 * scaled(8, scale, 1);
    std::vector<double> qs;
    for (std::size_t r = begin; r < rows.size(); ++r) {
        const bool border = r == begin || r + 1 == rows.size();
        if (border || std::abs(rows[r].q - centre) > 1.15 * room) qs.push_back(rows[r].q);
    }
    for (int i = 0; i <= cells; ++i) qs.push_back(centre + room * (2.0 * i / cells - 1));
    std::sort(qs.begin(), qs.end());
    const int first_row = rows[begin].vertex_row;
    rows.resize(begin);
    for (std::size_t i = 0; i < qs.size(); ++i) {
        rows.push_back({Stretch::nakago, qs[i], first_row + static_cast<int>(i)});
    }
}

std::vector<RowPlace> make_rows(const KatanaShape& shape, double scale) {
    const KatanaParameters& p = shape.parameters();
    std::vector<RowPlace> rows;
    int vertex_row = 0;
    for (const Stretch stretch : stretches) {
        int cells = 1;
        switch (stretch) {
            case Stretch::jiri:
                cells = scaled(24, scale, 3);
                break;
            case Stretch::nakago:
                cells = scaled(100, scale, 4);
                break;
            case Stretch::machi:
                cells = 1;
                break;
            case Stretch::blade:
                cells = scaled(470, scale, 8);
                break;
            case Stretch::kissaki:
                cells = scaled(90 * std::clamp(p.kissaki_mm / 33, 0.7, 3.0), scale, 6);
                break;
        }
        const auto [first, last] = shape.range(stretch);
        for (int i = 0; i <= cells; ++i) {
            double x = static_cast<double>(i) / cells;
            // Closer towards the tip, where the fukura turns most for each mm of the mune.
            if (stretch == Stretch::kissaki) x = 1 - std::pow(1 - x, 1.35);
            const double q = i == cells ? last : first + (last - first) * x;
            rows.push_back({stretch, q, vertex_row + i});
        }
        if (stretch == Stretch::nakago && p.mekugi_ana_mm > 0) {
            crowd_at_hole(rows, rows.size() - static_cast<std::size_t>(cells) - 1, p, scale);
            cells = rows.back().vertex_row - vertex_row;
        }
        vertex_row += cells;
    }
    return rows;
}

glm::vec3 tangent_along(const KatanaShape::Row& row, const SurfacePoint& p) {
    const glm::dvec3 t(row.line.tangent.x, 0, row.line.tangent.y);
    glm::dvec3 projected = t - p.normal * glm::dot(t, p.normal);
    // Walls across the blade (machi, nakago's end) face along it: there, the way the surface runs.
    if (glm::length(projected) < 0.3) projected = p.along - p.normal * glm::dot(p.along, p.normal);
    return glm::normalize(projected);
}

class Builder {
  public:
    Builder(const KatanaParameters& parameters, double detail)
        : shape_(parameters),
          chart_(shape_),
          columns_(make_columns(shape_, std::sqrt(detail))),
          rows_(make_rows(shape_, std::sqrt(detail))) {}

    KatanaMesh build() {
        mesh_.frame = chart_.frame();
        evaluate();
        place_hole();
        number_vertices();
        place_landmarks();
        for (std::size_t r = 0; r + 1 < rows_.size(); ++r) {
            if (rows_[r].stretch == rows_[r + 1].stretch) add_faces(r);
        }
        if (hole_.exists) add_hole();
        mesh_.face_start.push_back(static_cast<std::int32_t>(mesh_.corner_vertex.size()));
        return std::move(mesh_);
    }

  private:
    [[nodiscard]] const Corner& corner(std::size_t row, int node) const {
        return corners_[row * columns_.nodes.size() + static_cast<std::size_t>(node)];
    }
    [[nodiscard]] int last_vertex_row() const { return rows_.back().vertex_row; }

    void evaluate() {
        const std::size_t width = columns_.nodes.size();
        corners_.resize(rows_.size() * width);
        parallel_for(rows_.size(), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) evaluate_row(r);
        });
    }

    void evaluate_row(std::size_t r) {
        const auto [stretch, q, vertex_row] = rows_[r];
        const bool end = vertex_row == 0;
        const bool tip = vertex_row == last_vertex_row();
        const KatanaShape::Row exact = shape_.row(stretch, q);
        // Ends are single points, and the foot closes at the machi: normals there are those just
        // before.
        double near_q = q;
        if (end) near_q = 1e-5;
        if (tip) near_q = q - 1e-5 * shape_.parameters().kissaki_mm;
        if (stretch == Stretch::machi && q >= 0) near_q = -1e-5;
        const KatanaShape::Row row = shape_.row(stretch, near_q);
        const ChartRow across = KatanaChart::row(shape_, stretch, near_q);
        const double s = chart_.s_mm(exact.arc_mm);
        const BladeFrame& frame = chart_.frame();
        for (std::size_t i = 0; i < columns_.nodes.size(); ++i) {
            Corner& c = corners_[r * columns_.nodes.size() + i];
            auto [strip, f] = columns_.nodes[i];
            const auto k = static_cast<std::size_t>(strip);
            double t = k == 0 ? 0 : across.strip_end_mm[k - 1];
            if (strip == Strip::foot && !shape_.has(strip, stretch)) {
                strip = Strip::ha;
                f = 1;
            } else {
                t += KatanaShape::developed_mm(row.section, strip, row.mune, f);
            }
            if (tip) t = 0;
            SurfacePoint p = row.at(strip, f);
            c.normal = p.normal;
            c.tangent = tangent_along(row, p);
            const MuneLine::Point& line = exact.line;
            c.position_mm =
                tip ? glm::dvec3(line.position_mm.x, 0, line.position_mm.y) : p.position_mm;
            c.s_mm = static_cast<float>(s);
            c.t_mm = static_cast<float>(t);
            c.uv = {(frame.chart_x_mm(s, t) + frame.nakago_mm) / frame.length_mm(),
                    0.5 - frame.chart_y_mm(s, t) / frame.chart_height_mm};
        }
    }

    // Vertex of a place in the grid; places that coincide share one.
    [[nodiscard]] std::size_t slot(int vertex_row, int column, bool omote) const {
        if (vertex_row == last_vertex_row()) column = 0;
        if (vertex_row == 0) {
            if (column > columns_.corner_column && column < columns_.edge_column)
                column = columns_.corner_column;
            if (column >= columns_.edge_column)
                column = columns_.corner_column - (column - columns_.edge_column);
        } else if (vertex_row >= machi_row_) {
            column = std::min(column, columns_.edge_column);
        }
        const bool middle = column == 0 || column == columns_.last_column ||
                            (vertex_row >= machi_row_ && column == columns_.edge_column);
        const int across = 2 * (columns_.last_column + 1);
        return static_cast<std::size_t>(vertex_row) * across + 2 * column +
               (omote || middle ? 0 : 1);
    }

    void number_vertices() {
        for (const RowPlace& r : rows_) {
            if (r.stretch == Stretch::machi) machi_row_ = r.vertex_row;
        }
        index_.assign(
            static_cast<std::size_t>(last_vertex_row() + 1) * 2 * (columns_.last_column + 1), -1);
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            for (std::size_t i = 0; i < columns_.nodes.size(); ++i) {
                const int column = column_of(static_cast<int>(i));
                if (hole_.swallows(r, column)) continue;
                for (const bool omote : {true, false}) {
                    std::int32_t& index = index_[slot(rows_[r].vertex_row, column, omote)];
                    if (index >= 0) continue;
                    index = static_cast<std::int32_t>(mesh_.positions_mm.size());
                    const Corner& c = corner(r, static_cast<int>(i));
                    glm::dvec3 position = c.position_mm;
                    const bool middle = slot(rows_[r].vertex_row, column, true) ==
                                        slot(rows_[r].vertex_row, column, false);
                    if (middle) position.y = 0;
                    if (!omote) position.y = -position.y;
                    mesh_.positions_mm.push_back(position);
                    mesh_.s_mm.push_back(c.s_mm);
                    mesh_.t_mm.push_back(c.t_mm);
                }
            }
        }
    }

    [[nodiscard]] int column_of(int node) const {
        const auto k =
            static_cast<std::size_t>(columns_.nodes[static_cast<std::size_t>(node)].strip);
        return columns_.first_column[k] + node - columns_.first_node[k];
    }

    [[nodiscard]] Part part_of(Stretch stretch, Strip strip) const {
        if (stretch <= Stretch::machi) return Part::nakago;
        const bool kissaki = stretch == Stretch::kissaki && shape_.has_yokote();
        switch (strip) {
            case Strip::mune_top:
            case Strip::mune_side:
                return Part::mune;
            case Strip::shinogi_ji:
                return Part::shinogi_ji;
            case Strip::ji:
                return kissaki ? Part::kissaki : Part::ji;
            case Strip::ha:
                return kissaki ? Part::boshi : Part::ha;
            case Strip::foot:
                break;
        }
        return Part::nakago;
    }

    void add_faces(std::size_t r) {
        for (const bool omote : {true, false}) {
            for (const Strip strip : strips) {
                const auto k = static_cast<std::size_t>(strip);
                for (int i = 0; i < columns_.cells[k]; ++i) {
                    if (hole_.covers(r, columns_.first_column[k] + i)) continue;
                    add_cell(r, columns_.first_node[k] + i, part_of(rows_[r].stretch, strip),
                             omote);
                }
            }
        }
    }

    [[nodiscard]] std::int32_t vertex(std::size_t row, int column, bool omote) const {
        return index_[slot(rows_[row].vertex_row, column, omote)];
    }

    void place_landmarks() {
        std::size_t machi = 0;
        std::size_t yokote = 0;
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            if (rows_[r].stretch == Stretch::machi) machi = r;
            if (rows_[r].stretch == Stretch::blade) yokote = r;
        }
        const int shinogi = columns_.first_column[static_cast<std::size_t>(Strip::ji)];
        KatanaLandmarks& m = mesh_.landmarks;
        m.tip = vertex(rows_.size() - 1, 0, true);
        m.nakago_end = vertex(0, 0, true);
        m.machi_ridge = vertex(machi, 0, true);
        m.machi_edge = vertex(machi, columns_.edge_column, true);
        m.yokote_ridge = vertex(yokote, 0, true);
        m.yokote_edge = vertex(yokote, columns_.edge_column, true);
        for (const std::size_t side : {0U, 1U}) {
            m.machi_corner[side] = vertex(machi, columns_.corner_column, side == 0);
            m.yokote_corner[side] = vertex(yokote, columns_.corner_column, side == 0);
            m.machi_shinogi[side] = vertex(machi, shinogi, side == 0);
            m.yokote_shinogi[side] = vertex(yokote, shinogi, side == 0);
        }
    }

    // The mekugi-ana: a block of cells of both sides is left out; rings of quads join its border to
    // a circle, and the two circles to each other. On a blade with a shinogi its centre lies on
    // that line.
    struct Hole {
        bool exists = false;
        std::size_t row_begin = 0, row_end = 0;  // rows at the block's borders
        int column_begin = 0, column_end = 0;
        int centre_column = 0;
        double centre_arc_mm = 0;
        double radius_mm = 0;
        [[nodiscard]] bool covers(std::size_t row, int column) const {
            return exists && row >= row_begin && row < row_end && column >= column_begin &&
                   column < column_end;
        }
        /// Vertices strictly inside the block.
        [[nodiscard]] bool swallows(std::size_t row, int column) const {
            return exists && row > row_begin && row < row_end && column > column_begin &&
                   column < column_end;
        }
    };

    [[nodiscard]] int node_of(int column, bool above_centre) const {
        // Strip borders have two nodes: the one of the strip that is asked for.
        int found = -1;
        for (std::size_t i = 0; i < columns_.nodes.size(); ++i) {
            if (column_of(static_cast<int>(i)) != column) continue;
            found = static_cast<int>(i);
            if (above_centre) break;
        }
        return found;
    }
    [[nodiscard]] double depth(const Section& s, int column) const {
        const auto [strip, f] = columns_.nodes[static_cast<std::size_t>(node_of(column, true))];
        Dual y;
        Dual d;
        KatanaShape::point_in_strip(s, strip, shape_.parameters().mune, Dual(f), y, d);
        return d.v;
    }

    void place_hole() {
        const KatanaParameters& p = shape_.parameters();
        if (p.mekugi_ana_mm <= 0) return;
        hole_.radius_mm = 0.5 * p.mekugi_ana_mm;
        hole_.centre_arc_mm = -p.mekugi_ana_from_machi_mm;
        const Section s = shape_.section(Stretch::nakago, Dual(hole_.centre_arc_mm));
        const int first = columns_.corner_column;
        const int last = columns_.edge_column;
        hole_.centre_column = columns_.first_column[static_cast<std::size_t>(Strip::ji)];
        if (!shape_.has_shinogi()) hole_.centre_column = (first + last) / 2;
        const double centre = depth(s, hole_.centre_column);
        const double room = 1.2 * hole_.radius_mm;
        hole_.column_begin = hole_.centre_column;
        hole_.column_end = hole_.centre_column;
        while (hole_.column_begin > first && centre - depth(s, hole_.column_begin) < room)
            --hole_.column_begin;
        while (hole_.column_end < last && depth(s, hole_.column_end) - centre < room)
            ++hole_.column_end;
        for (std::size_t r = 0; r < rows_.size(); ++r) {
            if (rows_[r].stretch != Stretch::nakago) continue;
            if (rows_[r].q <= hole_.centre_arc_mm - room) hole_.row_begin = r;
            hole_.row_end = r;
            if (rows_[r].q >= hole_.centre_arc_mm + room) break;
        }
        hole_.exists = true;
    }

    void add_hole() {
        struct Border {
            std::size_t row;
            int column;
        };
        std::vector<Border> border;
        for (std::size_t r = hole_.row_begin; r < hole_.row_end; ++r)
            border.push_back({r, hole_.column_begin});
        for (int c = hole_.column_begin; c < hole_.column_end; ++c)
            border.push_back({hole_.row_end, c});
        for (std::size_t r = hole_.row_end; r > hole_.row_begin; --r)
            border.push_back({r, hole_.column_end});
        for (int c = hole_.column_end; c > hole_.column_begin; --c)
            border.push_back({hole_.row_begin, c});

        // Each border vertex has its point on the circle, seen from the centre in the same
        // direction.
        const std::size_t n = border.size();
        std::vector<std::array<Corner, 2>> circle(
            n);  // as part of the strip above and of the one below
        std::vector<glm::dvec3> outwards(n);
        std::vector<std::array<std::int32_t, 2>> circle_vertex(n);
        for (std::size_t i = 0; i < n; ++i) {
            const Section at_border = shape_.section(Stretch::nakago, Dual(rows_[border[i].row].q));
            const glm::dvec2 from(
                rows_[border[i].row].q - hole_.centre_arc_mm,
                depth(at_border, border[i].column) - depth(at_border, hole_.centre_column));
            const glm::dvec2 unit = from / glm::length(from);
            const KatanaShape::Row row =
                shape_.row(Stretch::nakago, hole_.centre_arc_mm + hole_.radius_mm * unit.x);
            for (const std::size_t below : {0U, 1U}) {
                circle[i][below] = circle_corner(row, hole_.radius_mm * unit.y, below == 0);
            }
            for (const std::size_t side : {0U, 1U}) {
                circle_vertex[i][side] = static_cast<std::int32_t>(mesh_.positions_mm.size());
                glm::dvec3 position = circle[i][0].position_mm;
                if (side == 1) position.y = -position.y;
                mesh_.positions_mm.push_back(position);
                mesh_.s_mm.push_back(circle[i][0].s_mm);
                mesh_.t_mm.push_back(circle[i][0].t_mm);
            }
            const glm::dvec3 t(row.line.tangent.x, 0, row.line.tangent.y);
            const glm::dvec3 up(-row.line.tangent.y, 0, row.line.tangent.x);
            outwards[i] = t * unit.x - up * unit.y;
        }
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t j = (i + 1) % n;
            const bool above = border[i].column + border[j].column < 2 * hole_.centre_column;
            const std::size_t below = above ? 0 : 1;
            for (const std::size_t side : {0U, 1U}) {
                const bool omote = side == 0;
                const Corner& a = corner(
                    border[i].row,
                    node_of(border[i].column, above == (border[i].column == hole_.centre_column)));
                const Corner& b = corner(
                    border[j].row,
                    node_of(border[j].column, above == (border[j].column == hole_.centre_column)));
                std::array<std::pair<std::int32_t, Corner>, 4> quad{
                    std::pair{vertex(border[i].row, border[i].column, omote), a},
                    {vertex(border[j].row, border[j].column, omote), b},
                    {circle_vertex[j][side], circle[j][below]},
                    {circle_vertex[i][side], circle[i][below]}};
                if (!omote) {
                    std::reverse(quad.begin(), quad.end());
                    for (auto& [v, c] : quad) mirror(c);
                }
                add_face(quad, Part::nakago);
            }
            std::array<std::pair<std::int32_t, Corner>, 4> wall{
                std::pair{circle_vertex[i][0], circle[i][below]},
                {circle_vertex[j][0], circle[j][below]},
                {circle_vertex[j][1], circle[j][below]},
                {circle_vertex[i][1], circle[i][below]}};
            for (std::size_t k = 0; k < 4; ++k) {
                wall[k].second.normal = -outwards[k == 0 || k == 3 ? i : j];
                wall[k].second.tangent = {0, 1, 0};
            }
            add_face(wall, Part::nakago);
        }
    }

    [[nodiscard]] Corner circle_corner(const KatanaShape::Row& row, double below_centre_mm,
                                       bool above) const {
        const Section& s = row.section;
        const bool on_shinogi_ji = shape_.has_shinogi() && above;
        double f = 0;
        Strip strip = Strip::shinogi_ji;
        if (on_shinogi_ji) {
            f = 1 + below_centre_mm / (s.shinogi_d.v - s.corner_d.v);
        } else {
            double g = (depth(s, hole_.centre_column) + below_centre_mm - s.shinogi_d.v) /
                       (s.ji_end_d.v - s.shinogi_d.v);
            const double border = s.ha_fraction.v;
            strip = g <= border ? Strip::ji : Strip::ha;
            f = g <= border ? g / border : (g - border) / (1 - border);
        }
        const ChartRow across = KatanaChart::row(shape_, Stretch::nakago, row.arc_mm);
        const double t = across.strip_end_mm[static_cast<std::size_t>(strip) - 1] +
                         KatanaShape::developed_mm(s, strip, row.mune, f);
        const double along_s = chart_.s_mm(row.arc_mm);
        const BladeFrame& frame = chart_.frame();
        const SurfacePoint p = row.at(strip, f);
        Corner c;
        c.position_mm = p.position_mm;
        c.normal = p.normal;
        c.tangent = tangent_along(row, p);
        c.s_mm = static_cast<float>(along_s);
        c.t_mm = static_cast<float>(t);
        c.uv = {(frame.chart_x_mm(along_s, t) + frame.nakago_mm) / frame.length_mm(),
                0.5 - frame.chart_y_mm(along_s, t) / frame.chart_height_mm};
        return c;
    }

    static void mirror(Corner& c) {
        c.normal.y = -c.normal.y;
        c.tangent.y = -c.tangent.y;
        c.uv.y = 1 - c.uv.y;
    }

    void add_face(const std::array<std::pair<std::int32_t, Corner>, 4>& quad, Part part) {
        mesh_.face_start.push_back(static_cast<std::int32_t>(mesh_.corner_vertex.size()));
        mesh_.face_part.push_back(part);
        for (const auto& [v, c] : quad) {
            mesh_.corner_vertex.push_back(v);
            mesh_.corner_normal.push_back(c.normal);
            mesh_.corner_tangent.push_back(c.tangent);
            mesh_.corner_uv.push_back(c.uv);
        }
    }

    void add_cell(std::size_t r, int node, Part part, bool omote) {
        struct Place {
            std::size_t row;
            int node;
        };
        // Seen from outside with the tip to the right, omote has its ridge above: counter-clockwise
        // from there.
        std::array<Place, 4> places{Place{r, node}, Place{r, node + 1}, Place{r + 1, node + 1},
                                    Place{r + 1, node}};
        if (omote) std::reverse(places.begin(), places.end());
        std::array<std::int32_t, 4> ids{};
        std::array<Place, 4> kept{};
        std::size_t count = 0;
        for (const Place& place : places) {
            const std::int32_t v =
                index_[slot(rows_[place.row].vertex_row, column_of(place.node), omote)];
            if (count > 0 && ids[count - 1] == v) continue;
            ids[count] = v;
            kept[count++] = place;
        }
        if (count > 1 && ids[count - 1] == ids[0]) --count;
        if (count < 3) return;
        mesh_.face_start.push_back(static_cast<std::int32_t>(mesh_.corner_vertex.size()));
        mesh_.face_part.push_back(part);
        for (std::size_t i = 0; i < count; ++i) {
            Corner c = corner(kept[i].row, kept[i].node);
            if (!omote) mirror(c);
            mesh_.corner_vertex.push_back(ids[i]);
            mesh_.corner_normal.push_back(c.normal);
            mesh_.corner_tangent.push_back(c.tangent);
            mesh_.corner_uv.push_back(c.uv);
        }
    }

    KatanaShape shape_;
    KatanaChart chart_;
    Columns columns_;
    std::vector<RowPlace> rows_;
    std::vector<Corner> corners_;
    std::vector<std::int32_t> index_;
    int machi_row_ = 0;
    Hole hole_;
    KatanaMesh mesh_;
};

}  // namespace

KatanaMesh make_katana(const KatanaParameters& parameters, double detail) {
    if (!(detail >= 0.002 && detail <= 64)) {
        throw InputError("katana", "detail", std::to_string(detail),
                         "0.002 to 64 (1 gives some 50,000 vertices)");
    }
    return Builder(parameters, detail).build();
}

}  // namespace togishi
