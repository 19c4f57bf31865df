// How long a scanned blade takes to be prepared, and how good the result is. Prints one JSON
// object; tests/bench/scan_prepare.py runs it and writes the rows.
//
//   bench_scan_prepare ZUKURI TRIANGLES NOISE_MM ERROR_MM TEXTURE_WIDTH [MAPS]
//
// The scan: the default blade of that zukuri as a closed mesh of about so many triangles, none of
// whose vertices lies on a ridge, its points off by normal noise of that sigma in each direction,
// with vertex colours, in some pose. MAPS: a file to write width, height (64 bit), states (byte),
// normals (3 floats), displacement (float) and colours (4 bytes) to.
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>
#include <string>

#include "../cpp/katana_stations.hpp"
#include "../cpp/section_scan.hpp"
#include "base/error.hpp"
#include "blade/katana_mesh.hpp"
#include "scanned/prepare.hpp"

namespace {

using namespace togishi;

double cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peak_gib() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / (1024.0 * 1024.0);
}

template <class T>
void write(std::ofstream& out, const std::vector<T>& values) {
    out.write(reinterpret_cast<const char*>(values.data()),
              static_cast<std::streamsize>(values.size() * sizeof(T)));
}

int run(int argc, char** argv) {
    if (argc < 6) {
        std::cerr << "usage: bench_scan_prepare ZUKURI TRIANGLES NOISE_MM ERROR_MM TEXTURE_WIDTH "
                     "[MAPS]\n";
        return 2;
    }
    const double triangles = std::atof(argv[2]);
    const double noise_mm = std::atof(argv[3]);
    PrepareOptions options;
    options.error_mm = std::atof(argv[4]);
    options.detail.width = static_cast<std::size_t>(std::atoll(argv[5]));
    const ScannedStations stations = katana_stations(KatanaShape(katana_defaults(argv[1])));
    // About square cells: some 60 mm around a katana's section, of its length.
    const double length = stations.nakago_mm + stations.nagasa_arc_mm;
    const double columns = std::max(8.0, std::sqrt(0.5 * triangles * 60 / length));
    SectionScan shape;
    shape.columns = static_cast<std::size_t>(columns);
    shape.rows = static_cast<std::size_t>(0.5 * triangles / columns);
    shape.pose = tilted_pose({1e5, -2e5, 3e4});
    TriangleMesh scan = section_scan(stations, shape);
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, static_cast<float>(noise_mm));
    scan.colours.reserve(scan.positions.size());
    for (glm::vec3& p : scan.positions) {
        const float bands = 0.5F + 0.5F * std::sin(0.8F * p.x) * std::sin(0.8F * p.y);
        const auto grey = static_cast<std::uint8_t>(90 + 100 * bands);
        scan.colours.push_back({grey, grey, static_cast<std::uint8_t>(grey + 10), 255});
        if (noise_mm > 0) p += glm::vec3(noise(random), noise(random), noise(random));
    }
    const std::size_t count = scan.triangles.size();
    const double before_gib = peak_gib();
    const double before = cpu_seconds();
    const PreparedBlade blade = prepare_blade(std::move(scan), shape.pose, stations, {}, options);
    const double cpu = cpu_seconds() - before;
    std::printf("{\"triangles\": %zu, \"cpu_s\": %.3f, \"scan_gib\": %.3f, \"peak_gib\": %.3f, ",
                count, cpu, before_gib, peak_gib());
    std::printf(
        "\"cut\": %zu, \"stretch_99_pct\": %.3f, \"stretch_most_pct\": %.3f, \"width\": %zu, "
        "\"height\": %zu, ",
        blade.cut_triangles, blade.stretch_99_percent, blade.stretch_most_percent,
        blade.detail.width, blade.detail.height);
    std::printf("\"chart_stretch_pct\": %.3f, ",
                uv_stretch_percent(
                    on_chart(make_katana(katana_defaults(argv[1]), 0.3), ScannedChart(stations))));
    std::printf("\"seconds\": {");
    const char* comma = "";
    for (const auto& [step, time] : blade.time) {
        std::printf("%s\"%s\": [%.3f, %.3f]", comma, step.c_str(), time.seconds, time.cpu_seconds);
        comma = ", ";
    }
    std::printf("}, \"levels\": [");
    comma = "";
    for (const PreparedLevel& level : blade.levels) {
        std::printf(
            "%s{\"error_mm\": %.4f, \"distance_mm\": %.4f, \"rms_mm\": %.5f, "
            "\"triangles\": %zu}",
            comma, level.error_mm, level.distance.largest, level.distance.rms,
            level.mesh.face_count());
        comma = ", ";
    }
    std::printf("]}\n");
    if (argc > 6) {
        std::ofstream out(argv[6], std::ios::binary);
        const std::vector<std::uint64_t> size{blade.detail.width, blade.detail.height};
        write(out, size);
        write(out, blade.detail.state);
        write(out, blade.detail.normal);
        write(out, blade.detail.displacement_mm);
        write(out, blade.detail.colour);
        if (!out.good()) throw InputError(argv[6], "file", "not written", "a folder with room");
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
