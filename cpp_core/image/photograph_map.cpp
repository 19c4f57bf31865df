#include "image/photograph_map.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <future>
#include <system_error>
#include <thread>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "capture/tile_run.hpp"

namespace togishi {
namespace {

constexpr int tile_size = 64;
static_assert(cell_pixels == tile_size, "a band of cells is a band of tiles");

// Straight to the disk, but never failing before the writer: where a write fails, the OpenEXR
// library of Debian 12 waits for ever. What failed is asked afterwards.
class QuietFile : public OIIO::Filesystem::IOProxy {
  public:
    explicit QuietFile(const std::filesystem::path& path)
        : IOProxy(path.string(), Write), file_(std::fopen(path.c_str(), "wb")) {
        if (file_ == nullptr) reason_ = errno;
    }
    QuietFile(const QuietFile&) = delete;
    QuietFile& operator=(const QuietFile&) = delete;
    ~QuietFile() override { finish(); }
    [[nodiscard]] const char* proxytype() const override { return "togishi"; }
    void close() override { finish(); }
    size_t write(const void* buffer, size_t size) override {
        const size_t written = pwrite(buffer, size, m_pos);
        m_pos += static_cast<int64_t>(written);
        return written;
    }
    size_t pwrite(const void* buffer, size_t size, int64_t offset) override {
        if (reason_ == 0 && file_ != nullptr) {
            errno = 0;
            if (fseeko(file_, offset, SEEK_SET) != 0 || std::fwrite(buffer, 1, size, file_) != size)
                reason_ = errno == 0 ? EIO : errno;
        }
        size_ = std::max(size_, offset + static_cast<int64_t>(size));
        return size;
    }
    [[nodiscard]] size_t size() const override { return static_cast<size_t>(size_); }
    void flush() const override {}
    void finish() {
        if (file_ == nullptr) return;
        errno = 0;
        if (std::fclose(file_) != 0 && reason_ == 0) reason_ = errno == 0 ? EIO : errno;
        file_ = nullptr;
    }
    [[nodiscard]] int reason() const { return reason_; }

  private:
    std::FILE* file_;
    int reason_ = 0;
    int64_t size_ = 0;
};

}  // namespace

void write_capture_map(const std::filesystem::path& path, TileStore& tiles,
                       const std::string& source, const std::string& software,
                       MapPrecision precision, unsigned threads) {
    if (path.extension() != ".exr")
        throw InputError(path.string(), "extension", path.extension().string(), ".exr");
    if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
    OIIO::ImageSpec spec(
        static_cast<int>(tiles.width()), static_cast<int>(tiles.height()),
        static_cast<int>(capture_channels.size()),
        precision == MapPrecision::half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    spec.tile_width = spec.tile_height = tile_size;
    spec.channelnames.assign(capture_channels.begin(), capture_channels.end());
    spec.alpha_channel = spec.z_channel = -1;
    spec.attribute("compression", "zip:2");  // as small as level 4, sooner
    spec.attribute("Software", software);
    spec.attribute("togishi:capture", 1);
    spec.attribute("togishi:source", source);
    AtomicFile file(path);
    QuietFile quiet(file.path());
    // Compression takes as long as a sixth of the fit: on all threads.
    OIIO::attribute("exr_threads", static_cast<int>(threads));
    const auto out = OIIO::ImageOutput::create("openexr");
    if (!out || !out->set_ioproxy(&quiet))
        throw std::runtime_error("OpenImageIO writes no OpenEXR here: " + OIIO::geterror());
    if (!out->open(file.path().string(), spec)) file.fail_writing(out->geterror());
    // The next band comes from the disk while one is compressed.
    const auto read = [&tiles](std::size_t b) {
        return std::async(std::launch::async, [&tiles, b] { return tiles.read(b); });
    };
    std::future<std::vector<float>> next = read(0);
    for (std::size_t b = 0; b < tiles.bands() && quiet.reason() == 0; ++b) {
        const std::vector<float> pixels = next.get();
        if (b + 1 < tiles.bands()) next = read(b + 1);
        const auto begin = static_cast<int>(b * tiles.band_rows());
        if (!out->write_tiles(0, spec.width, begin, begin + static_cast<int>(tiles.rows_of(b)), 0,
                              1, OIIO::TypeDesc::FLOAT, pixels.data()))
            file.fail_writing(out->geterror());
    }
    if (!out->close() && quiet.reason() == 0) file.fail_writing(out->geterror());
    quiet.finish();
    if (quiet.reason() != 0) file.fail_writing(std::generic_category().message(quiet.reason()));
    file.commit();
    tiles.remove();
}

}  // namespace togishi
