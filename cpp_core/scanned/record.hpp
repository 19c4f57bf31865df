// What was done to a scan, so that an archive can keep it beside the result: JSON-LD with the terms
// of CIDOC-CRM 7.1 and of CRMdig (docs/scan_import.md lists which term says what).
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace togishi {

using RecordValue = std::variant<double, bool, std::string>;

/// A file that the import read or wrote.
struct RecordFile {
    std::string name;  ///< without folders: a record must not tell where somebody keeps files
    std::string role;  ///< "scan", "blade", "normal map", ...
    std::string sha256;
    std::uint64_t bytes = 0;
};

/// Something that came out of a step: a count (unit "") or a measure.
struct RecordFigure {
    std::string name;
    double value = 0;
    std::string unit;
};

struct RecordStep {
    std::string name;  ///< "read", "unit", "clean", "align", "measure", "label", "prepare"
    std::vector<std::pair<std::string, RecordValue>> parameters;
    std::vector<RecordFigure> figures;
    std::vector<std::string> notes;
};

/// One dimension of the sword with its standard uncertainty.
struct RecordDimension {
    std::string name;
    double value = 0;
    std::optional<double> sigma;  ///< same unit; absent where none was estimated
    std::string unit;             ///< "mm", "deg" or "" for a word's number
    std::string note;
};

struct ScanRecord {
    std::string object_id, title, holder, rights;  ///< as the archivist gave them; may be empty
    std::string software_version;
    std::string created_utc;  ///< ISO 8601, as 2026-11-23T11:30:00Z; empty where it must not vary
    double mm_per_unit = 1;
    std::string unit_how;  ///< how the unit was decided
    std::vector<RecordFile> inputs, outputs;
    std::vector<RecordStep> steps;
    std::vector<RecordDimension> dimensions;
    std::vector<std::string> inferred;  ///< what was not measured but concluded
};

/// JSON-LD text, UTF-8 (bytes that are not are replaced), numbers as they round-trip.
[[nodiscard]] std::string record_json(const ScanRecord& record);

/// Throws InputError naming `where` and the field for what is no such record, is of a later format,
/// or is longer than 16 MiB.
[[nodiscard]] ScanRecord parse_record(std::string_view text, const std::string& where);
[[nodiscard]] ScanRecord read_record(const std::filesystem::path& file);

}  // namespace togishi
