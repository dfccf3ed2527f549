// What the program tells: tables on the terminal and JSON for machines.
#pragma once

#include "apps/bench/machine.h"
#include "apps/bench/rig.h"
#include "apps/bench/stopwatch.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sfumato::bench {

using Json = nlohmann::ordered_json;

class Table {
  public:
    // The first `left` columns are text, flushed left; the others are figures.
    Table(std::vector<std::string> headings, size_t left);
    void add(std::vector<std::string> cells);
    std::string text() const;

  private:
    std::vector<std::vector<std::string>> rows_;
    size_t left_;
};

std::string fixed(double value, int decimals); // "-" for NaN

// The first line of every table: program, command, device.
std::string header_text(const std::string& command, Rig& rig);
std::string machine_text(const Machine& machine);

Json device_json(Rig& rig);
Json machine_json(const Machine& machine);
Json statistics_json(const Statistics& statistics);

// Prints to standard output; nothing if the JSON goes there.
class Output {
  public:
    explicit Output(std::string json_path) : json_path_(std::move(json_path)) {}
    void print(const std::string& text) const;
    // A line that is overwritten, on a terminal only.
    void progress(const std::string& text) const;
    // To the file, written aside and renamed, or to standard output for "-"; nowhere for "".
    Result<void> write(const Json& json) const;

  private:
    std::string json_path_;
};

} // namespace sfumato::bench
