#include "scan/scan_channel.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "spectral/colour_space.hpp"
#include "spectral/colour_weights.hpp"
#include "spectral/light.hpp"
#include "spectral/observer.hpp"

namespace togishi {

std::optional<ScanChannel> parse_channel(std::string_view title) {
    using Kind = ScanChannel::Kind;
    constexpr std::string_view stem = "intensity";
    if (!title.starts_with(stem)) return std::nullopt;
    ScanChannel channel;
    channel.name = title;
    title.remove_prefix(stem.size());
    constexpr std::array<std::pair<std::string_view, Kind>, 7> kinds{{{"", Kind::y},
                                                                      {"_x", Kind::x},
                                                                      {"_y", Kind::y},
                                                                      {"_z", Kind::z},
                                                                      {"_r", Kind::r},
                                                                      {"_g", Kind::g},
                                                                      {"_b", Kind::b}}};
    for (const auto& [name, kind] : kinds) {
        if (title != name) continue;
        channel.kind = kind;
        return channel;
    }
    if (!title.starts_with('_') || !title.ends_with("nm")) return std::nullopt;
    const auto nm = parse_number(title.substr(1, title.size() - 3));
    // The light itself must be seen there: find_light has lines from 400 to 700 nm.
    if (!nm || !(*nm >= 400 && *nm <= 700)) return std::nullopt;
    channel.kind = Kind::wavelength;
    channel.wavelength_nm = *nm;
    return channel;
}

ChannelSpectrum channel_spectrum(const ScanChannel& channel, const std::string& light) {
    using Kind = ScanChannel::Kind;
    if (channel.kind == Kind::wavelength)
        return {"line:" + format_number(channel.wavelength_nm), {0, 1, 0}};
    const glm::dvec3 white =
        colour_weights(*find_light(light), *find_observer(default_observer)).white;
    glm::dvec3 weights(0.0);
    if (channel.kind == Kind::x) weights.x = 1;
    if (channel.kind == Kind::y) weights.y = 1;
    if (channel.kind == Kind::z) weights.z = 1;
    if (channel.kind == Kind::r || channel.kind == Kind::g || channel.kind == Kind::b) {
        const auto matrix =
            rgb_from_xyz(find_colour_space("rec709"), find_adaptation("none"), white);
        const int row = channel.kind == Kind::r ? 0 : channel.kind == Kind::g ? 1 : 2;
        weights = {matrix[0][row], matrix[1][row], matrix[2][row]};
    }
    const double own = glm::dot(weights, white);
    if (!(own > 1e-3)) {
        throw InputError("scans", channel.name, "a channel that sees nothing of the light " + light,
                         "channels in which the light itself is seen");
    }
    return {light, weights / own};
}

std::string format_number(double value) {
    std::array<char, 32> buffer{};
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    return {buffer.data(), end};
}

}  // namespace togishi
