// Distance to the zero line of a field: how deep a point lies in the hardened steel.
#pragma once
#include "steel/field_grid.hpp"

namespace togishi {

/// Signed distance (mm) to the zero line of `field`, positive where the field is, to 2 % (chamfer 5
/// x 5); beside the line from the field's own slope. Distances are cut at `limit_mm`.
[[nodiscard]] FieldGrid distance_to_zero(const FieldGrid& field, float limit_mm);

}  // namespace togishi
