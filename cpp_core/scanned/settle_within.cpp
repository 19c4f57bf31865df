#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "scanned/settle.hpp"

namespace togishi {
namespace {

// Vertices keep the bound, what lies between them need not.
constexpr double of_bound = 0.94;
constexpr int most_attempts = 12;
// Less of the bound is allowed about a place that came out too far; after four times nothing.
constexpr float less = 0.6F;
constexpr float least_of_bound = 0.1F;
// Towards a point of the scan that lies too far off, of its distance.
constexpr float step_share = 0.4F;
// Denser than what the result is measured with.
constexpr std::size_t denser = 5;

/// How far each vertex may go, and where to.
class Bounds {
  public:
    Bounds(const ChartedMesh& mesh, const ScannedChart& chart, double error_mm)
        : mesh_(mesh.mesh),
          chart_(chart),
          tree_(mesh_),
          most_mm_(static_cast<float>(of_bound * error_mm)),
          of_vertex_(mesh_.positions.size(), most_mm_),
          shift_(mesh_.positions.size(), 0),
          around_(triangles_around(mesh_)) {}

    [[nodiscard]] const std::vector<float>& of_vertex() const { return of_vertex_; }
    [[nodiscard]] const std::vector<float>& shift() const { return shift_; }

    /// Less about these places: the vertices of the triangle there and their neighbours; where the
    /// scan itself lies off the surface, first a step towards it. False where nothing is left to
    /// take.
    bool lessen(const std::vector<glm::vec3>& places) {
        std::vector<std::uint32_t> which;
        std::map<std::uint32_t, float> towards;
        for (const glm::vec3& p : places) {
            const auto off = static_cast<float>(chart_.place(glm::dvec3(p)).off_mm);
            const bool step = std::abs(off) > 0.5F * most_mm_ && std::abs(off) < 2 * most_mm_;
            for (const std::uint32_t v :
                 mesh_.triangles[tree_.nearest(p, SurfaceTree::Search{}).triangle]) {
                for (const std::uint32_t f : around_[v]) {
                    const Triangle& t = mesh_.triangles[f];
                    for (const std::uint32_t w : t) {
                        if (step && shift_[w] == 0) {
                            towards[w] = step_share * off;
                        } else {
                            which.push_back(w);
                        }
                    }
                }
            }
        }
        for (const auto& [v, shift] : towards) shift_[v] = shift;
        std::sort(which.begin(), which.end());
        which.erase(std::unique(which.begin(), which.end()), which.end());
        bool any = !towards.empty();
        for (const std::uint32_t v : which) {
            any = any || of_vertex_[v] > 0;
            of_vertex_[v] *= less;
            if (of_vertex_[v] < least_of_bound * most_mm_) of_vertex_[v] = 0;
        }
        return any;
    }

  private:
    const TriangleMesh& mesh_;
    const ScannedChart& chart_;
    SurfaceTree tree_;
    float most_mm_;
    std::vector<float> of_vertex_, shift_;
    std::vector<std::vector<std::uint32_t>> around_;
};

}  // namespace

bool settle_within(ChartedMesh& mesh, const ScannedChart& chart, const TriangleMesh& scan,
                   double error_mm, std::size_t samples, SettledCount& count,
                   MeshDistance& distance) {
    const SurfaceTree tree(scan);
    Bounds bounds(mesh, chart, error_mm);
    const auto bound = static_cast<float>(error_mm);
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
        SettleOptions options;
        options.error_mm = of_bound * error_mm;
        options.vertex_error_mm = bounds.of_vertex();
        options.vertex_shift_mm = bounds.shift();
        ChartedMesh settled = mesh;
        const SettledCount counted = settle(settled, chart, tree, options);
        std::vector<glm::vec3> beyond = points_beyond(
            scan, settled.mesh.origin, SurfaceTree(settled.mesh), bound, denser * samples);
        const std::vector<glm::vec3> back =
            points_beyond(settled.mesh, scan.origin, tree, bound, denser * samples);
        beyond.insert(beyond.end(), back.begin(), back.end());
        if (!beyond.empty() && attempt + 1 < most_attempts && bounds.lessen(beyond)) continue;
        const MeshDistance measured = mesh_distance(scan, tree, settled.mesh, samples);
        if (measured.largest > error_mm || counted.left_mm2 > counted.stretched_mm2) return false;
        mesh = std::move(settled);
        count = counted;
        distance = measured;
        return true;
    }
    return false;
}

}  // namespace togishi
