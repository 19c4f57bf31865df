// What a user did wrong, said so that the user can mend it.
#pragma once
#include <stdexcept>
#include <string>
#include <string_view>

namespace togishi {

/// Bad input: names where it stands, the field, the value found and what is allowed.
/// The command line prints it and ends with exit code 2; Python sees togishi_core.InputError (a
/// ValueError).
class InputError : public std::runtime_error {
  public:
    /// `where`: file (with line where known) or argument; `field`: its name; `found`: the value as
    /// read; `allowed`: what would be accepted, with units.
    InputError(std::string_view where, std::string_view field, std::string_view found,
               std::string_view allowed);
};

}  // namespace togishi
