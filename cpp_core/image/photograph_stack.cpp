#include "image/photograph_stack.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <sstream>

#include <OpenImageIO/imageio.h>

#include "base/error.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t most_pixels = std::int64_t{1} << 30;
constexpr int most_side = 200'000, most_channels = 16;

std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text.empty() ? "no reason given" : text;
}

struct Photograph {
    fs::path path;
    std::unique_ptr<OIIO::ImageInput> in;
    OIIO::ImageSpec spec;
    std::vector<int> channels;  // one, or red, green, blue
    double step = 0;            // of quantisation; 0: float
};

// Which channels make the number: one, or red, green and blue.
std::vector<int> channels_of(const Photograph& p, const std::string& asked) {
    const auto find = [&](const std::string& name) {
        const auto& names = p.spec.channelnames;
        const auto at = std::find(names.begin(), names.end(), name);
        return at == names.end() ? -1 : static_cast<int>(at - names.begin());
    };
    if (asked == "luminance") {
        const int r = find("R"), g = find("G"), b = find("B");
        if (r >= 0 && g >= 0 && b >= 0) return {r, g, b};
        if (p.spec.nchannels <= 2) return {0};  // grey, perhaps with alpha
    } else if (const int one = find(asked); one >= 0) {
        return {one};
    }
    std::string names;
    for (const std::string& name : p.spec.channelnames) names += (names.empty() ? "" : ", ") + name;
    throw InputError(p.path.string(), "channel", asked + " not among " + names,
                     "luminance of a grey or R, G, B picture, or the name of one of its channels");
}

class Photographs : public TileReader {
  public:
    Photographs(const std::vector<fs::path>& files, const PhotographOptions& options)
        : options_(options) {
        // We read many files at once ourselves.
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
        for (const fs::path& file : files) open(file);
        double coarsest = 0;
        for (const Photograph& p : photographs_) coarsest = std::max(coarsest, p.step);
        variance_ = coarsest * coarsest / 12;
    }

    [[nodiscard]] std::size_t width() const override {
        return static_cast<std::size_t>(photographs_.front().spec.width);
    }
    [[nodiscard]] std::size_t height() const override {
        return static_cast<std::size_t>(photographs_.front().spec.height);
    }
    [[nodiscard]] std::size_t images() const override { return photographs_.size(); }
    [[nodiscard]] double quantisation_variance() const override { return variance_; }

    [[nodiscard]] std::string fingerprint() const override {
        std::ostringstream text;
        text.precision(17);
        text << static_cast<int>(options_.transfer) << ' ' << options_.channel << ' '
             << options_.black << ' ' << options_.clip << '\n';
        for (const Photograph& p : photographs_) {
            struct stat s {};
            if (stat(p.path.c_str(), &s) != 0) s.st_size = 0;
            text << p.path.string() << ' ' << s.st_size << ' ' << s.st_mtim.tv_sec << '.'
                 << s.st_mtim.tv_nsec << '\n';
        }
        return text.str();
    }

    void read(std::size_t image, std::size_t begin, std::size_t end, float* values,
              std::uint8_t* clipped) override {
        Photograph& p = photographs_.at(image);
        const int first = *std::min_element(p.channels.begin(), p.channels.end());
        const int last = *std::max_element(p.channels.begin(), p.channels.end()) + 1;
        const auto used = static_cast<std::size_t>(last - first);
        // A file in tiles gives whole rows of tiles.
        std::size_t from = begin, to = end;
        if (p.spec.tile_height > 0) {
            const auto tile = static_cast<std::size_t>(p.spec.tile_height);
            from = begin / tile * tile;
            to = std::min(height(), (end + tile - 1) / tile * tile);
        }
        std::vector<float> rows((to - from) * width() * used);
        const auto y0 = p.spec.y + static_cast<int>(from), y1 = p.spec.y + static_cast<int>(to);
        const bool good =
            p.spec.tile_width > 0
                ? p.in->read_tiles(0, 0, p.spec.x, p.spec.x + p.spec.width, y0, y1, p.spec.z,
                                   p.spec.z + 1, first, last, OIIO::TypeDesc::FLOAT, rows.data())
                : p.in->read_scanlines(0, 0, y0, y1, p.spec.z, first, last, OIIO::TypeDesc::FLOAT,
                                       rows.data());
        // Some readers fill what is missing and only leave a message.
        if (!good || p.in->has_error()) {
            throw InputError(p.path.string(),
                             "rows " + std::to_string(begin) + " to " + std::to_string(end - 1),
                             "unreadable (" + one_line(p.in->geterror()) + ")",
                             "a whole picture; finished tiles are kept");
        }
        StoredRows stored{rows.data() + (begin - from) * width() * used,
                          (end - begin) * width(),
                          used,
                          {},
                          p.step};
        stored.channels.reserve(p.channels.size());
        for (const int channel : p.channels)
            stored.channels.push_back(static_cast<std::size_t>(channel - first));
        to_signal(stored, options_, values, clipped);
    }

  private:
    void open(const fs::path& file) {
        Photograph p;
        p.path = file;
        std::error_code error;
        if (!fs::is_regular_file(file, error)) {
            throw InputError(file.string(), "picture", error ? error.message() : "missing",
                             "an existing picture");
        }
        p.in = OIIO::ImageInput::open(file.string());
        if (!p.in) {
            throw InputError(file.string(), "picture",
                             "unreadable (" + one_line(OIIO::geterror()) + ")",
                             "a picture in a format that OpenImageIO reads");
        }
        p.spec = p.in->spec();
        const OIIO::ImageSpec& s = p.spec;
        if (s.width < 1 || s.height < 1 || s.width > most_side || s.height > most_side ||
            std::int64_t{s.width} * s.height > most_pixels || s.depth != 1 || s.nchannels < 1 ||
            s.nchannels > most_channels) {
            throw InputError(file.string(), "size",
                             std::to_string(s.width) + " x " + std::to_string(s.height) + " x " +
                                 std::to_string(s.depth) + ", " + std::to_string(s.nchannels) +
                                 " channels",
                             "1 to 200000 pixels either way, 2^30 in all, up to 16 channels");
        }
        if (!photographs_.empty() && (s.width != photographs_.front().spec.width ||
                                      s.height != photographs_.front().spec.height)) {
            throw InputError(file.string(), "size",
                             std::to_string(s.width) + " x " + std::to_string(s.height),
                             std::to_string(photographs_.front().spec.width) + " x " +
                                 std::to_string(photographs_.front().spec.height) + ", as " +
                                 photographs_.front().path.string() + " has");
        }
        if (!s.format.is_floating_point()) {
            int bits = s.get_int_attribute("oiio:BitsPerSample", 0);
            if (bits < 1 || bits > 32) bits = static_cast<int>(8 * s.format.size());
            p.step = 1 / (std::exp2(bits) - 1);
        }
        p.channels = channels_of(p, options_.channel);
        photographs_.push_back(std::move(p));
    }

    PhotographOptions options_;
    std::vector<Photograph> photographs_;
    double variance_ = 0;
};

}  // namespace

std::unique_ptr<TileReader> open_photographs(const std::vector<fs::path>& files,
                                             const PhotographOptions& options) {
    if (files.empty()) throw InputError("photographs", "pictures", "none", "one or more pictures");
    check_signal(options);
    return std::make_unique<Photographs>(files, options);
}

}  // namespace togishi
