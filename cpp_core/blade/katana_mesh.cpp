#include "blade/katana_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

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
        number_vertices();
        for (std::size_t r = 0; r + 1 < rows_.size(); ++r) {
            if (rows_[r].stretch == rows_[r + 1].stretch) add_faces(r);
        }
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
                    0.5 - t / frame.chart_height_mm};
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
                    add_cell(r, columns_.first_node[k] + i, part_of(rows_[r].stretch, strip),
                             omote);
                }
            }
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
        std::array<std::int32_t, 4> vertex{};
        std::array<Place, 4> kept{};
        std::size_t count = 0;
        for (const Place& place : places) {
            const std::int32_t v =
                index_[slot(rows_[place.row].vertex_row, column_of(place.node), omote)];
            if (count > 0 && vertex[count - 1] == v) continue;
            vertex[count] = v;
            kept[count++] = place;
        }
        if (count > 1 && vertex[count - 1] == vertex[0]) --count;
        if (count < 3) return;
        mesh_.face_start.push_back(static_cast<std::int32_t>(mesh_.corner_vertex.size()));
        mesh_.face_part.push_back(part);
        for (std::size_t i = 0; i < count; ++i) {
            const Corner& c = corner(kept[i].row, kept[i].node);
            glm::vec3 n = c.normal;
            glm::vec3 t = c.tangent;
            glm::vec2 uv = c.uv;
            if (!omote) {
                n.y = -n.y;
                t.y = -t.y;
                uv.y = 1 - uv.y;
            }
            mesh_.corner_vertex.push_back(vertex[i]);
            mesh_.corner_normal.push_back(n);
            mesh_.corner_tangent.push_back(t);
            mesh_.corner_uv.push_back(uv);
        }
    }

    KatanaShape shape_;
    KatanaChart chart_;
    Columns columns_;
    std::vector<RowPlace> rows_;
    std::vector<Corner> corners_;
    std::vector<std::int32_t> index_;
    int machi_row_ = 0;
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
