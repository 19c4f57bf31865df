// Time and memory of a scan's way from its file to a light mesh: scan_mesh.py runs it.
//   bench_scan_mesh FILE.ply MILLIONS NOISE_MM ERROR_MM...
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include "mesh/clean.hpp"
#include "mesh/holes.hpp"
#include "mesh/pieces.hpp"
#include "mesh/simplify.hpp"
#include "mesh_file/read_mesh.hpp"
#include "mesh_file/write_ply.hpp"

namespace {

using namespace togishi;

/// A blade's surface as a scanner has it: a bent bar of shinogi-zukuri section, 750 mm long, noise
/// in every vertex, a scale bar beside it, coordinates far from zero.
TriangleMesh scan(double triangles, double noise_mm) {
    const double around_mm = 76, length_mm = 750;
    const double step = std::sqrt(2 * around_mm * length_mm / triangles);
    const auto around = static_cast<std::uint32_t>(around_mm / step);
    const auto along = static_cast<std::uint32_t>(length_mm / step);
    const std::array<glm::dvec2, 6> corner{
        {{0, 0.3}, {8, 3.4}, {32, 0}, {8, -3.4}, {0, -0.3}, {-0.4, 0}}};
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal(0, noise_mm);
    TriangleMesh mesh;
    mesh.origin = {100'000, -50'000, 20'000};
    mesh.positions.reserve(std::size_t{around} * (along + 1) + 2);
    for (std::uint32_t i = 0; i <= along; ++i) {
        const double s = length_mm * (static_cast<double>(i) / along - 0.5);
        const double taper = 1 - 0.25 * i / along, sori = 18 * (1 - s * s / 140'625);
        for (std::uint32_t k = 0; k < around; ++k) {
            const double at = 6.0 * k / around;
            const auto side = static_cast<std::size_t>(at);
            const glm::dvec2 p =
                glm::mix(corner[side], corner[(side + 1) % 6], at - std::floor(at));
            mesh.positions.emplace_back(s + normal(random), taper * p.y + normal(random),
                                        sori - taper * p.x + normal(random));
        }
    }
    const auto vertex = [&](std::uint32_t i, std::uint32_t k) { return i * around + k % around; };
    mesh.triangles.reserve(std::size_t{2} * around * along + std::size_t{2} * around);
    for (std::uint32_t i = 0; i < along; ++i) {
        for (std::uint32_t k = 0; k < around; ++k) {
            mesh.triangles.push_back({vertex(i, k), vertex(i + 1, k), vertex(i + 1, k + 1)});
            mesh.triangles.push_back({vertex(i, k), vertex(i + 1, k + 1), vertex(i, k + 1)});
        }
    }
    for (std::uint32_t k = 1; k + 1 < around; ++k) {
        mesh.triangles.push_back({vertex(0, 0), vertex(0, k), vertex(0, k + 1)});
        mesh.triangles.push_back({vertex(along, 0), vertex(along, k + 1), vertex(along, k)});
    }
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& p : {glm::vec3(0, 0, -90), {100, 0, -90}, {0, 20, -90}, {0, 0, -80}})
        mesh.positions.push_back(p);
    for (const Triangle& t : {Triangle{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}})
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    return mesh;
}

double cpu_s() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
}

/// The highest memory since the last call, GiB.
double peak_gib() {
    std::ifstream status("/proc/self/status");
    double kib = 0;
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with("VmHWM:")) kib = std::strtod(line.c_str() + 6, nullptr);
    }
    std::ofstream("/proc/self/clear_refs") << "5";
    return kib / (1024 * 1024);
}

template <class Step>
void timed(const char* name, const Step& step) {
    (void)peak_gib();
    const double cpu = cpu_s();
    const auto begin = std::chrono::steady_clock::now();
    step();
    const double wall =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("\"%s\": {\"s\": %.4g, \"cpu_s\": %.4g, \"peak_gib\": %.4g}", name, wall,
                cpu_s() - cpu, peak_gib());
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fputs("bench_scan_mesh FILE.ply MILLIONS NOISE_MM ERROR_MM...\n", stderr);
        return 2;
    }
    const std::filesystem::path path = argv[1];
    if (!std::filesystem::exists(path)) {
        write_ply(path, scan(1e6 * std::strtod(argv[2], nullptr), std::strtod(argv[3], nullptr)));
    }
    TriangleMesh mesh;
    CleanReport report;
    std::printf("{");
    timed("read", [&] { mesh = read_mesh(path).mesh; });
    const std::size_t triangles = mesh.triangles.size();
    std::printf(",\n ");
    timed("clean", [&] { report = clean(mesh); });
    std::printf(",\n ");
    timed("pieces", [&] { mesh = take_piece(mesh, sort_into_pieces(mesh).front()); });
    std::printf(",\n ");
    timed("holes", [&] { (void)find_holes(mesh); });
    std::printf(",\n \"triangles\": %zu, \"holes_and_pieces\": %zu, \"simplified\": [", triangles,
                report.triangles_after);
    for (int i = 4; i < argc; ++i) {
        SimplifyOptions options;
        options.error_mm = std::strtod(argv[i], nullptr);
        SimplifiedMesh light;
        std::printf("%s\n  {", i == 4 ? "" : ",");
        timed("simplify", [&] { light = simplify(mesh, options); });
        std::printf(
            ", \"bound_mm\": %g, \"triangles\": %zu, \"largest_mm\": %.4g, \"rms_mm\": %.4g, "
            "\"p99_mm\": %.4g, \"attempts\": %d}",
            options.error_mm, light.mesh.triangles.size(), light.distance.largest,
            light.distance.rms, light.distance.p99, light.attempts);
        std::fflush(stdout);
    }
    std::printf("]}\n");
    return 0;
}
