#include "spectral/observer.hpp"

#include <string>
#include <utility>

#include "base/error.hpp"
#include "spectral/embedded_data.hpp"
#include "spectral/linear_table.hpp"

namespace togishi {

Observer::Observer(TableFile table) : table_(std::move(table)) {
    for (std::size_t c = 1; c <= 3; ++c) {
        for (std::size_t row = 0; row < table_.rows(); ++row) {
            if (table_.columns[c][row] < 0.0) {
                throw InputError(table_.at(row), "colour-matching function",
                                 std::to_string(table_.columns[c][row]), "0 or more");
            }
        }
    }
    on_full_ = at(grid_full);
}

std::array<std::vector<double>, 3> Observer::at(const Grid& grid) const {
    const auto nm = grid.wavelengths_nm();
    return {linear_at(table_.columns[0], table_.columns[1], nm),
            linear_at(table_.columns[0], table_.columns[2], nm),
            linear_at(table_.columns[0], table_.columns[3], nm)};
}

const std::vector<std::shared_ptr<const Observer>>& builtin_observers() {
    static const auto observers = [] {
        std::vector<std::shared_ptr<const Observer>> all;
        for (const auto& file : embedded_files()) {  // sorted by path: 1931 before 1964
            if (!file.path.starts_with("observers/")) continue;
            all.push_back(std::make_shared<const Observer>(
                parse_table(file.text, "data/" + std::string(file.path), "observer", 4,
                            TableMetadata::required)));
        }
        return all;
    }();
    return observers;
}

std::shared_ptr<const Observer> find_observer(std::string_view name) {
    std::string known;
    for (const auto& observer : builtin_observers()) {
        if (observer->name() == name) return observer;
        known += (known.empty() ? "" : ", ") + std::string(observer->name());
    }
    throw InputError("observer", "name", "\"" + std::string(name) + "\"", known);
}

}  // namespace togishi
