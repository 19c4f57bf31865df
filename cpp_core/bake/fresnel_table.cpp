#include "bake/fresnel_table.hpp"

#include <list>
#include <mutex>
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

}  // namespace

MetalReflectance::MetalReflectance(const RefractiveIndex& on_61, std::size_t size)
    : size_(checked_size(size)), reflectance_(size * grid_61.count) {
    for (std::size_t i = 0; i < size; ++i) {
        const double cos_theta =
            f64::fresnel_table_cosine(static_cast<double>(i), static_cast<double>(size));
        double* out = reflectance_.data() + i * grid_61.count;
        for (std::size_t w = 0; w < grid_61.count; ++w) {
            out[w] = f64::fresnel_conductor(on_61.n[w], on_61.k[w], cos_theta);
        }
    }
}

std::vector<float> fresnel_table(const MetalReflectance& metal, const ColourWeights& weights,
                                 const glm::dmat3& rgb_from_xyz) {
    std::vector<float> table(metal.size() * 3);
    for (std::size_t i = 0; i < metal.size(); ++i) {
        const glm::dvec3 rgb = rgb_from_xyz * weights.xyz(metal.row(i));
        table[3 * i] = static_cast<float>(rgb.x);
        table[3 * i + 1] = static_cast<float>(rgb.y);
        table[3 * i + 2] = static_cast<float>(rgb.z);
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
