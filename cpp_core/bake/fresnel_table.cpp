#include "bake/fresnel_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "brdf/model.hpp"

namespace togishi {

namespace {

constexpr std::size_t kept_reflectances = 16;

// The most recently used first. A metal is told by its object: find_metal returns the same one for
// the same file as long as the file has not changed, and holding it here keeps its address from
// being reused.
std::shared_ptr<const MetalReflectance> kept_reflectance(const std::shared_ptr<const Metal>& metal,
                                                         std::size_t size) {
    struct Entry {
        std::shared_ptr<const Metal> metal;
        std::shared_ptr<const MetalReflectance> reflectance;
    };
    static std::mutex guard;
    static std::list<Entry> entries;
    {
        const std::lock_guard lock(guard);
        for (auto entry = entries.begin(); entry != entries.end(); ++entry) {
            if (entry->metal == metal && entry->reflectance->size() == size) {
                entries.splice(entries.begin(), entries, entry);
                return entries.front().reflectance;
            }
        }
    }
    auto reflectance = std::make_shared<const MetalReflectance>(metal->at(grid_61), size);
    const std::lock_guard lock(guard);
    entries.push_front({metal, reflectance});
    if (entries.size() > kept_reflectances) entries.pop_back();
    return reflectance;
}

std::size_t checked_size(std::size_t size) {
    if (size < min_table_size || size > max_table_size) {
        throw InputError("Fresnel table", "size", std::to_string(size),
                         std::to_string(min_table_size) + " to " + std::to_string(max_table_size));
    }
    return size;
}

// F at `count` cosines, one row of 61 each.
template <class Cosine>
std::vector<double> reflectances(const RefractiveIndex& on_61, std::size_t count,
                                 const Cosine& cosine) {
    std::vector<double> all(count * grid_61.count);
    for (std::size_t i = 0; i < count; ++i) {
        const double cos_theta = cosine(i);
        double* out = all.data() + i * grid_61.count;
        for (std::size_t w = 0; w < grid_61.count; ++w) {
            out[w] = f64::fresnel_conductor(on_61.n[w], on_61.k[w], cos_theta);
        }
    }
    return all;
}

constexpr std::size_t degree = table_nodes - 1;

// From cos(theta) = 0 to 1.
double node(std::size_t j) {
    const double turn = std::numbers::pi * static_cast<double>(j) / degree;
    return 0.5 * (1.0 - std::cos(turn));
}

// shares()[order][j]: what sample j adds to the coefficient of T_order(2 cos(theta) - 1).
using Shares = std::array<std::array<double, table_nodes>, table_nodes>;
const Shares& shares() {
    static const auto all = [] {
        auto halved_at_ends = [](std::size_t i) { return i == 0 || i == degree ? 0.5 : 1.0; };
        Shares s{};
        for (std::size_t order = 0; order < table_nodes; ++order) {
            for (std::size_t j = 0; j < table_nodes; ++j) {
                const auto steps = static_cast<double>(order * (degree - j) % (2 * degree));
                s[order][j] = halved_at_ends(order) * halved_at_ends(j) * 2.0 / degree *
                              std::cos(std::numbers::pi * steps / degree);
            }
        }
        return s;
    }();
    return all;
}

// Whether the series of every wavelength has ended: what is left out is about as large as the last
// terms, since they fall by a factor of two and more each.
bool has_converged(const std::vector<double>& at_nodes) {
    constexpr double tolerance = 1e-8;
    constexpr std::size_t last_terms = 3;
    for (std::size_t order = table_nodes - last_terms; order < table_nodes; ++order) {
        std::array<double, grid_61.count> term{};
        for (std::size_t j = 0; j < table_nodes; ++j) {
            const double part = shares()[order][j];
            const double* f = at_nodes.data() + j * grid_61.count;
            for (std::size_t w = 0; w < grid_61.count; ++w) term[w] += part * f[w];
        }
        for (const double t : term) {
            if (!(std::abs(t) <= tolerance)) return false;
        }
    }
    return true;
}

// Rows of a table from its colours at the nodes: Clenshaw's sum, several rows at a time.
std::vector<float> expanded(const std::vector<glm::dvec3>& at_nodes, std::size_t size) {
    std::array<std::array<double, table_nodes>, 3> series{};
    for (std::size_t order = 0; order < table_nodes; ++order) {
        glm::dvec3 sum(0.0);
        for (std::size_t j = 0; j < table_nodes; ++j) sum += shares()[order][j] * at_nodes[j];
        for (int c = 0; c < 3; ++c) series[static_cast<std::size_t>(c)][order] = sum[c];
    }
    constexpr std::size_t lanes = 16;
    std::vector<float> table(size * 3);
    for (std::size_t first = 0; first < size; first += lanes) {
        std::array<double, lanes> twice_z{};
        for (std::size_t l = 0; l < lanes; ++l) {
            const auto i = static_cast<double>(std::min(first + l, size - 1));
            twice_z[l] = 4.0 * f64::fresnel_table_cosine(i, static_cast<double>(size)) - 2.0;
        }
        for (std::size_t c = 0; c < 3; ++c) {
            std::array<double, lanes> b1{};
            std::array<double, lanes> b2{};
            for (std::size_t order = degree; order >= 1; --order) {
                const double a = series[c][order];
                for (std::size_t l = 0; l < lanes; ++l) {
                    const double b = twice_z[l] * b1[l] - b2[l] + a;
                    b2[l] = b1[l];
                    b1[l] = b;
                }
            }
            const std::size_t used = std::min(lanes, size - first);
            for (std::size_t l = 0; l < used; ++l) {
                table[3 * (first + l) + c] =
                    static_cast<float>(0.5 * twice_z[l] * b1[l] - b2[l] + series[c][0]);
            }
        }
    }
    return table;
}

}  // namespace

MetalReflectance::MetalReflectance(const RefractiveIndex& on_61, std::size_t size, TableRows rows)
    : size_(checked_size(size)),
      by_polynomial_(rows == TableRows::fast && size > exact_table_size) {
    if (by_polynomial_) {
        reflectance_ = reflectances(on_61, table_nodes, node);
        by_polynomial_ = has_converged(reflectance_);
    }
    if (!by_polynomial_) {
        reflectance_ = reflectances(on_61, size, [&](std::size_t i) {
            return f64::fresnel_table_cosine(static_cast<double>(i), static_cast<double>(size));
        });
    }
}

std::vector<float> fresnel_table(const MetalReflectance& metal, const ColourWeights& weights,
                                 const glm::dmat3& rgb_from_xyz) {
    std::vector<glm::dvec3> colours(metal.samples());
    for (std::size_t i = 0; i < colours.size(); ++i) {
        colours[i] = rgb_from_xyz * weights.xyz(metal.sample(i));
    }
    if (metal.by_polynomial()) return expanded(colours, metal.size());
    std::vector<float> table;
    table.reserve(colours.size() * 3);
    for (const auto& rgb : colours) {
        for (int c = 0; c < 3; ++c) table.push_back(static_cast<float>(rgb[c]));
    }
    return table;
}

std::vector<float> fresnel_table(const FresnelTableRequest& request) {
    const auto& space = find_colour_space(request.space);
    const auto adaptation = find_adaptation(request.adaptation);
    const auto weights =
        colour_weights(*find_light(request.light), *find_observer(request.observer));
    const auto reflectance =
        kept_reflectance(find_metal(request.metal), checked_size(request.size));
    return fresnel_table(*reflectance, weights, rgb_from_xyz(space, adaptation, weights.white));
}

}  // namespace togishi
