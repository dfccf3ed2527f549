// Tables and JSON.
#include "apps/bench/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <unistd.h>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

size_t shown_width(const std::string& text) {
    // UTF-8: bytes that continue a character take no place.
    return static_cast<size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

} // namespace

Table::Table(std::vector<std::string> headings, size_t left) : left_(left) {
    rows_.push_back(std::move(headings));
}

void Table::add(std::vector<std::string> cells) {
    rows_.push_back(std::move(cells));
}

std::string Table::text() const {
    std::vector<size_t> widths(rows_.front().size(), 0);
    for (const auto& row : rows_)
        for (size_t i = 0; i < std::min(row.size(), widths.size()); ++i)
            widths[i] = std::max(widths[i], shown_width(row[i]));
    std::string text;
    for (size_t r = 0; r < rows_.size(); ++r) {
        std::string line;
        for (size_t i = 0; i < std::min(rows_[r].size(), widths.size()); ++i) {
            const std::string padding(widths[i] - shown_width(rows_[r][i]), ' ');
            line += (i == 0 ? "" : "  ") + (i < left_ ? rows_[r][i] + padding : padding + rows_[r][i]);
        }
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + "\n";
        if (r == 0)
            text += std::string(shown_width(line), '-') + "\n";
    }
    return text;
}

std::string fixed(double value, int decimals) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

std::string header_text(const std::string& command, Rig& rig) {
    const apps::DeviceDescription& device = rig.device().description();
    return fmt::format("sfumato-bench {} on {} ({}, Vulkan {}{})\n", command, device.name, device.type,
                       device.api_version, device.driver.empty() ? "" : ", " + device.driver);
}

std::string machine_text(const Machine& machine) {
    return fmt::format("copy, read + written: {:.0f} GB/s by a compute shader, {:.0f} GB/s by vkCmdCopyImage; an empty "
                       "dispatch with its barrier: {:.4f} ms\n",
                       machine.compute_copy * 1e-9, machine.transfer_copy * 1e-9, machine.dispatch_ms);
}

Json device_json(Rig& rig) {
    const apps::DeviceDescription& device = rig.device().description();
    return {{"name", device.name},
            {"type", device.type},
            {"api_version", device.api_version},
            {"driver", device.driver},
            {"memory_bytes", device.memory_bytes}};
}

Json machine_json(const Machine& machine) {
    return {{"compute_copy_bytes_per_second", machine.compute_copy},
            {"transfer_copy_bytes_per_second", machine.transfer_copy},
            {"empty_dispatch_ms", machine.dispatch_ms}};
}

Json statistics_json(const Statistics& statistics) {
    return {{"median_ms", statistics.median},
            {"minimum_ms", statistics.minimum},
            {"p95_ms", statistics.p95},
            {"samples", statistics.samples}};
}

void Output::print(const std::string& text) const {
    if (json_path_ == "-")
        return;
    if (isatty(STDERR_FILENO))
        std::fputs("\r\x1b[K", stderr);
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
}

void Output::progress(const std::string& text) const {
    if (isatty(STDERR_FILENO))
        std::fprintf(stderr, "\r\x1b[K%s", text.c_str());
}

Result<void> Output::write(const Json& json) const {
    if (json_path_.empty())
        return {};
    const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    if (json_path_ == "-") {
        std::fputs(text.c_str(), stdout);
        return {};
    }
    const std::string aside = json_path_ + ".part";
    std::FILE* file = std::fopen(aside.c_str(), "wb");
    if (file == nullptr)
        return Error{ErrorCode::input, json_path_ + ": cannot be written"};
    const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
    const bool closed = std::fclose(file) == 0;
    std::error_code failed;
    if (written && closed)
        std::filesystem::rename(aside, json_path_, failed);
    if (!written || !closed || failed) {
        std::error_code ignored;
        std::filesystem::remove(aside, ignored);
        return Error{ErrorCode::input, json_path_ + ": cannot be written"};
    }
    return {};
}

} // namespace sfumato::bench
