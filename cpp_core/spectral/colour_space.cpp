#include "spectral/colour_space.hpp"

#include <algorithm>
#include <array>

#include "base/error.hpp"

namespace togishi {

namespace {

glm::dvec3 from_chromaticity(const glm::dvec2& xy) {
    return {xy.x / xy.y, 1.0, (1.0 - xy.x - xy.y) / xy.y};
}

// The columns of XYZ-from-RGB are the primaries, scaled so that RGB = (1, 1, 1) is the white (SMPTE
// RP 177).
ColourSpace by_primaries(std::string_view name, std::string_view title, const glm::dvec2& red,
                         const glm::dvec2& green, const glm::dvec2& blue, const glm::dvec2& white) {
    const glm::dmat3 primaries(from_chromaticity(red), from_chromaticity(green),
                               from_chromaticity(blue));
    const glm::dvec3 white_xyz = from_chromaticity(white);
    const glm::dvec3 amounts = glm::inverse(primaries) * white_xyz;
    const glm::dmat3 xyz_from_rgb(primaries[0] * amounts.x, primaries[1] * amounts.y,
                                  primaries[2] * amounts.z);
    return {name, title, white_xyz, glm::inverse(xyz_from_rgb)};
}

// Rows as printed in the sources; glm holds columns.
glm::dmat3 cones_from_xyz(Adaptation adaptation) {
    if (adaptation == Adaptation::bradford) {
        return glm::transpose(glm::dmat3(0.8951, 0.2664, -0.1614,  //
                                         -0.7502, 1.7135, 0.0367,  //
                                         0.0389, -0.0685, 1.0296));
    }
    return glm::transpose(glm::dmat3(0.401288, 0.650173, -0.051461,  //
                                     -0.250268, 1.204414, 0.045854,  //
                                     -0.002079, 0.048952, 0.953127));
}

constexpr glm::dvec2 d65_white{0.3127, 0.3290};
constexpr glm::dvec2 aces_white{0.32168, 0.33767};

ColourSpace acescg_from_d65(const ColourSpace& acescg) {
    ColourSpace space = acescg;
    space.name = "acescg_d65";
    space.title = "ACEScg of XYZ adapted from D65 (Bradford), as Blender converts";
    space.white_xyz = from_chromaticity(d65_white);
    space.rgb_from_xyz = acescg.rgb_from_xyz *
                         adaptation_matrix(Adaptation::bradford, space.white_xyz, acescg.white_xyz);
    return space;
}

}  // namespace

std::span<const ColourSpace> colour_spaces() {
    static const auto spaces = [] {
        const auto acescg = by_primaries("acescg", "ACEScg (AP1, ACES white)", {0.713, 0.293},
                                         {0.165, 0.830}, {0.128, 0.044}, aces_white);
        return std::array<ColourSpace, 5>{
            by_primaries("rec709", "Linear Rec.709", {0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06},
                         d65_white),
            by_primaries("rec2020", "Linear Rec.2020", {0.708, 0.292}, {0.170, 0.797},
                         {0.131, 0.046}, d65_white),
            acescg, acescg_from_d65(acescg),
            ColourSpace{"xyz", "CIE XYZ", glm::dvec3(1.0), glm::dmat3(1.0)}};
    }();
    return spaces;
}

const ColourSpace& find_colour_space(std::string_view name) {
    std::string known;
    for (const auto& space : colour_spaces()) {
        if (space.name == name) return space;
        known += (known.empty() ? "" : ", ") + std::string(space.name);
    }
    throw InputError("colour space", "name", "\"" + std::string(name) + "\"", known);
}

Adaptation find_adaptation(std::string_view name) {
    if (name == "none") return Adaptation::none;
    if (name == "bradford") return Adaptation::bradford;
    if (name == "cat16") return Adaptation::cat16;
    throw InputError("chromatic adaptation", "name", "\"" + std::string(name) + "\"",
                     "none, bradford, cat16");
}

glm::dmat3 adaptation_matrix(Adaptation adaptation, const glm::dvec3& from, const glm::dvec3& to) {
    if (adaptation == Adaptation::none) return glm::dmat3(1.0);
    constexpr double smallest_response = 1e-6;  // of the largest
    const glm::dmat3 cones = cones_from_xyz(adaptation);
    const glm::dvec3 source = cones * from;
    const glm::dvec3 target = cones * to;
    const double limit = smallest_response * std::max({source.x, source.y, source.z});
    if (!(source.x > limit && source.y > limit && source.z > limit)) {
        throw InputError("chromatic adaptation", "white of the light",
                         "XYZ " + std::to_string(from.x) + ", " + std::to_string(from.y) + ", " +
                             std::to_string(from.z),
                         "a white with some red, green and blue in it; for so saturated a light "
                         "choose \"none\"");
    }
    const glm::dmat3 gain(target.x / source.x, 0.0, 0.0, 0.0, target.y / source.y, 0.0, 0.0, 0.0,
                          target.z / source.z);
    return glm::inverse(cones) * gain * cones;
}

glm::dmat3 rgb_from_xyz(const ColourSpace& space, Adaptation adaptation,
                        const glm::dvec3& light_white) {
    return space.rgb_from_xyz * adaptation_matrix(adaptation, light_white, space.white_xyz);
}

}  // namespace togishi
