#include "capture/tile_store.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <system_error>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/sha256.hpp"

namespace togishi {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t header_bytes = 128;

// FNV-1a over 64-bit words; never 0, which stands for a band that is not there.
std::uint64_t checksum(const std::vector<float>& pixels) {
    std::uint64_t hash = 0xcbf29ce484222325U;
    for (const float v : pixels) {
        std::uint32_t bits = 0;
        std::memcpy(&bits, &v, sizeof bits);
        hash = (hash ^ bits) * 0x100000001b3U;
    }
    return hash == 0 ? 1 : hash;
}

}  // namespace

TileStore::TileStore(const fs::path& target, const std::string& fingerprint, std::size_t width,
                     std::size_t height, std::size_t channels, std::size_t band_rows)
    : width_(width), height_(height), channels_(channels), band_rows_(band_rows) {
    check_output_folder(target);
    const std::string stated = fingerprint + "\n" + std::to_string(width) + " " +
                               std::to_string(height) + " " + std::to_string(channels) + " " +
                               std::to_string(band_rows);
    const std::string hash = sha256_hex(stated);
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    const std::string stem = "." + target.filename().string() + ".";
    path_ = folder / (stem + hash.substr(0, 16) + ".tiles");
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with(stem) && name.ends_with(".tiles") && entry.path() != path_)
            fs::remove(entry.path(), error);
    }
    std::string header = "togishi tiles 1\n" + hash + "\n";
    header.resize(header_bytes, '\n');
    sums_.assign(bands(), 0);
    file_.open(path_, std::ios::in | std::ios::out | std::ios::binary);
    if (file_.is_open()) {
        std::string found(header_bytes, '\0');
        file_.read(found.data(), header_bytes);
        file_.read(reinterpret_cast<char*>(sums_.data()),
                   static_cast<std::streamsize>(sums_.size() * sizeof sums_[0]));
        if (file_.good() && found == header) return;
        file_.close();
        sums_.assign(bands(), 0);
    }
    file_.clear();
    file_.open(path_, std::ios::in | std::ios::out | std::ios::binary | std::ios::trunc);
    file_.write(header.data(), header_bytes);
    file_.write(reinterpret_cast<const char*>(sums_.data()),
                static_cast<std::streamsize>(sums_.size() * sizeof sums_[0]));
    file_.flush();
    if (!file_.good()) {
        throw InputError(path_.string(), "output", "not to be written",
                         "a folder with room for the finished tiles");
    }
}

std::size_t TileStore::rows_of(std::size_t band) const {
    return std::min(band_rows_, height_ - band * band_rows_);
}

std::size_t TileStore::finished_bands() const {
    return static_cast<std::size_t>(
        std::count_if(sums_.begin(), sums_.end(), [](std::uint64_t s) { return s != 0; }));
}

std::uint64_t TileStore::place_of(std::size_t band) const {
    return header_bytes + sums_.size() * sizeof sums_[0] +
           std::uint64_t{band} * band_rows_ * width_ * channels_ * sizeof(float);
}

void TileStore::write(std::size_t band, const std::vector<float>& pixels) {
    const std::uint64_t sum = checksum(pixels);
    file_.clear();
    file_.seekp(static_cast<std::streamoff>(place_of(band)));
    file_.write(reinterpret_cast<const char*>(pixels.data()),
                static_cast<std::streamsize>(pixels.size() * sizeof(float)));
    file_.flush();
    // Only what is whole is marked.
    if (file_.good()) {
        file_.seekp(static_cast<std::streamoff>(header_bytes + band * sizeof sum));
        file_.write(reinterpret_cast<const char*>(&sum), sizeof sum);
        file_.flush();
    }
    if (!file_.good()) {
        throw InputError(path_.string(), "output", "not written whole (disk full?)",
                         "room for the finished tiles; those that are there are kept");
    }
    sums_[band] = sum;
}

std::vector<float> TileStore::read(std::size_t band) {
    std::vector<float> pixels(rows_of(band) * width_ * channels_);
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(place_of(band)));
    file_.read(reinterpret_cast<char*>(pixels.data()),
               static_cast<std::streamsize>(pixels.size() * sizeof(float)));
    if (!file_.good() || checksum(pixels) != sums_[band]) {
        throw InputError(path_.string(), "finished tiles", "damaged",
                         "the file as an earlier run left it; remove it and run again");
    }
    return pixels;
}

void TileStore::remove() {
    file_.close();
    std::error_code ignored;  // a file that is already gone is what was wanted
    fs::remove(path_, ignored);
}

}  // namespace togishi
