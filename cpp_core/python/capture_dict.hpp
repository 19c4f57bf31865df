// What the bindings of the capture share: options from a dict, cameras and landmarks as dicts.
#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/camera_pose.hpp"
#include "capture/silhouette.hpp"
#include "plot/canvas.hpp"

namespace togishi {

/// Takes options out of a mapping; finish() refuses what nobody asked for. Throws InputError naming
/// `where` and the key.
class OptionReader {
  public:
    OptionReader(std::string where, const pybind11::handle& mapping);
    /// Each leaves its target where the key is missing or None, and says whether it was there.
    bool number(const char* key, double& target);
    bool truth(const char* key, bool& target);
    bool text(const char* key, std::string& target);
    bool choice(const char* key, const std::vector<std::string>& names, std::size_t& target);
    bool whole(const char* key, std::size_t& target);
    bool numbers(const char* key, std::size_t count, std::vector<double>& target);
    /// Any value; None where it is missing.
    pybind11::object object(const char* key);
    void finish() const;

  private:
    std::string where_, known_;
    pybind11::dict left_;
};

[[nodiscard]] Camera camera_from_dict(const pybind11::handle& mapping);
[[nodiscard]] pybind11::dict dict_from_camera(const Camera& camera);
[[nodiscard]] std::vector<Landmark> landmarks_from_list(const pybind11::handle& list);
[[nodiscard]] pybind11::dict dict_from_fit(const CameraFit& fit);

[[nodiscard]] pybind11::dict dict_from_outline(const SilhouetteFit& fit);

/// A Python callable, or None, as a native progress: what it answers, called with the GIL; it has
/// to live as long as the result.
[[nodiscard]] std::function<bool(double)> progress_of(const pybind11::object& progress);

/// (H, W, 3) uint8, the top row first.
[[nodiscard]] pybind11::array_t<std::uint8_t> array_of(const Picture& picture);

}  // namespace togishi
