#include "base/error.hpp"

namespace togishi {

InputError::InputError(std::string_view where, std::string_view field, std::string_view found,
                       std::string_view allowed)
    : std::runtime_error(std::string(where) + ": " + std::string(field) + " is " +
                         std::string(found) + "; allowed: " + std::string(allowed)) {}

}  // namespace togishi
