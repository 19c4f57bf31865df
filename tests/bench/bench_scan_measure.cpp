// How well scans are measured: simulated scans of known blades. scan_measure.py runs it and reads
// one JSON object per scan.
//   bench_scan_measure SHAPE TRIANGLES NOISE_MM SEED UNIT_MM SAMPLES REPLICATES [habaki] [no_tang]
//                      [stand] [holes] [write=FILE.ply]
// With write= the scan is only made and written.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <set>
#include <string>
#include <string_view>

#include "mesh/unit_guess.hpp"
#include "mesh_file/write_ply.hpp"
#include "scanned/label_parts.hpp"
#include "scanned/scan_analysis.hpp"
#include "simulate_scan_mesh.hpp"

namespace {

using namespace togishi;

void print(const ScanMesh& scan, const ScanAnalysis& found, double label_share, double seconds,
           bool unit_asked) {
    const bool faces = glm::dot(glm::transpose(found.pose.rotation)[1], scan.rotation[1]) > 0.99;
    const bool ahead = glm::dot(glm::transpose(found.pose.rotation)[0], scan.rotation[0]) > 0.99;
    std::printf(
        "{\"verdict\": \"%s\", \"sides_right\": %s, \"label_share\": %.6f, \"noise_mm\": %.5f, "
        "\"triangles\": %zu, \"seconds\": %.3f, \"unit_asked\": %s, \"measures\": {",
        std::string(verdict_name(found.verdict)).c_str(), faces && ahead ? "true" : "false",
        label_share, found.noise_mm, scan.mesh.triangles.size(), seconds,
        unit_asked ? "true" : "false");
    const char* comma = "";
    for (const ScanMeasure& m : found.measures) {
        const auto truth = scan.truth.find(m.name);
        if (truth == scan.truth.end()) continue;
        std::printf("%s\"%s\": [%.6f, %.6f, %.6f]", comma, m.name.c_str(), m.value, m.sigma,
                    truth->second);
        comma = ", ";
    }
    std::printf("}}\n");
}

int run(int count, char** words) {
    const std::string shape = words[1];
    ScanMeshOptions options;
    options.triangles = std::atof(words[2]);
    options.noise_mm = std::atof(words[3]);
    options.seed = std::strtoull(words[4], nullptr, 10);
    options.mm_per_unit = std::atof(words[5]);
    options.offset_mm = 1e5;
    const std::set<std::string> with(words + 8, words + count);
    options.habaki = with.contains("habaki");
    options.tang = !with.contains("no_tang");
    options.stand = with.contains("stand");
    options.edge_holes = with.contains("holes") ? 4 : 0;
    ScanMesh scan = simulate_scan_mesh(scan_shape(shape), options);
    constexpr std::string_view write = "write=";
    for (const std::string& word : with) {
        if (!word.starts_with(write)) continue;
        write_ply(word.substr(write.size()), scan.mesh);
        return 0;
    }

    ScanAnalysisOptions how;
    how.samples = std::atof(words[6]);
    how.replicates = std::atoi(words[7]);
    const auto begin = std::chrono::steady_clock::now();
    // The unit by the largest piece, whatever way it lies.
    const MeshPiece largest = find_pieces(scan.mesh).pieces.at(0);
    const UnitGuess guess = guess_unit(largest.extent(), largest.rough_width());
    // Where two units are plausible the user is asked, and knows.
    const double mm = guess.ambiguous ? options.mm_per_unit : millimetres_in(guess.unit);
    scan.mesh.origin *= mm;
    for (glm::vec3& p : scan.mesh.positions) p *= static_cast<float>(mm);
    const MeshPieces pieces = find_pieces(scan.mesh);
    const ScanAnalysis found = analyse_scan(scan.mesh, pieces, how);
    double right = 0;
    double all = 0;
    if (!found.stations.stations.empty()) {
        ChartOptions chart;
        chart.ha_haba_mm = scan.parameters.ha_haba_mm;  // no scan tells the hamon
        const std::vector<Part> part =
            label_parts(scan.mesh, pieces, found, ScannedChart(found.stations, chart));
        for (std::size_t f = 0; f < part.size(); ++f) {
            const double here = triangle_area(scan.mesh, scan.mesh.triangles[f]);
            all += here;
            if (part[f] == scan.part[f]) right += here;
        }
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    print(scan, found, all > 0 ? right / all : 0, seconds.count(), guess.ambiguous);
    return 0;
}

}  // namespace

int main(int count, char** words) {
    if (count < 8) {
        std::fprintf(stderr, "SHAPE TRIANGLES NOISE_MM SEED UNIT_MM SAMPLES REPLICATES ...\n");
        return 2;
    }
    try {
        return run(count, words);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
