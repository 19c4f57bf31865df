#include "spectral/metal.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/error.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/file_cache.hpp"

namespace togishi {

namespace {

constexpr std::size_t metal_columns = 3;

// n and k must reach over the visible range; what is beyond it is asked for by the reference only.
void check(const TableFile& table) {
    if (table.rows() < 2 || table.columns[0].front() > grid_61.first_nm ||
        table.columns[0].back() < grid_61.last_nm()) {
        throw InputError(table.where, "wavelength range",
                         std::to_string(table.columns[0].front()) + " to " +
                             std::to_string(table.columns[0].back()) + " nm",
                         "400 nm or below to 700 nm or above, in nm");
    }
    for (std::size_t row = 0; row < table.rows(); ++row) {
        const double n = table.columns[1][row];
        const double k = table.columns[2][row];
        if (n < 0.0 || k < 0.0 || n + k == 0.0 || n > 1000.0 || k > 1000.0) {
            throw InputError(table.at(row), "refractive index n, k",
                             std::to_string(n) + ", " + std::to_string(k), "0 to 1000, not both 0");
        }
    }
}

}  // namespace

Metal::Metal(TableFile table) : table_(std::move(table)) {
    check(table_);
    n_ = Pchip(table_.columns[0], table_.columns[1]);
    k_ = Pchip(table_.columns[0], table_.columns[2]);
}

RefractiveIndex Metal::at(std::span<const double> wavelengths_nm) const {
    RefractiveIndex index;
    index.n.reserve(wavelengths_nm.size());
    index.k.reserve(wavelengths_nm.size());
    for (const double nm : wavelengths_nm) {
        if (!(nm >= first_nm() && nm <= last_nm())) {
            throw InputError("metal " + std::string(name()), "wavelength",
                             std::to_string(nm) + " nm",
                             std::to_string(first_nm()) + " to " + std::to_string(last_nm()) +
                                 " nm, the range that was measured");
        }
        index.n.push_back(n_(nm));
        index.k.push_back(k_(nm));
    }
    return index;
}

const std::vector<std::shared_ptr<const Metal>>& builtin_metals() {
    static const auto metals = [] {
        std::vector<std::shared_ptr<const Metal>> all;
        for (const auto& file : embedded_files()) {
            if (!file.path.starts_with("metals/")) continue;
            all.push_back(std::make_shared<const Metal>(
                parse_table(file.text, "data/" + std::string(file.path), "metal", metal_columns,
                            TableMetadata::required)));
        }
        // As a user would look for them, the default first; files not named here follow by name.
        constexpr std::array<std::string_view, 6> order{default_metal,
                                                        "iron_querry",
                                                        "stainless_ferritic_karlsson",
                                                        "copper_johnson_christy",
                                                        "gold_johnson_christy",
                                                        "silver_johnson_christy"};
        std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
            return std::find(order.begin(), order.end(), a->name()) <
                   std::find(order.begin(), order.end(), b->name());
        });
        return all;
    }();
    return metals;
}

std::shared_ptr<const Metal> find_metal(std::string_view name) {
    std::string known;
    for (const auto& metal : builtin_metals()) {
        if (metal->name() == name) return metal;
        known += std::string(metal->name()) + ", ";
    }
    const bool prefixed = name.starts_with("csv:");
    const std::filesystem::path path(prefixed ? name.substr(4) : name);
    if (prefixed || path.has_parent_path() || path.extension() == ".csv") {
        static FileCache<Metal> files;
        return files.get(path, [&] {
            return std::make_shared<const Metal>(parse_table(read_table_text(path), path.string(),
                                                             "metal", metal_columns,
                                                             TableMetadata::required));
        });
    }
    throw InputError("metal", "name", "\"" + std::string(name) + "\"",
                     known + "or the path of a .csv file");
}

}  // namespace togishi
