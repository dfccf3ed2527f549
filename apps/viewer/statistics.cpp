// Median, minimum and maximum of recent times.
#include "apps/viewer/statistics.h"

#include <algorithm>
#include <cstddef>

namespace sfumato::viewer {

void TimeSeries::add(double value) {
    if (values_.size() == most)
        values_.erase(values_.begin());
    values_.push_back(static_cast<float>(value));
}

double TimeSeries::median() const {
    if (values_.empty())
        return 0.0;
    std::vector<float> sorted = values_;
    const auto middle = sorted.begin() + static_cast<ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    if (sorted.size() % 2 == 1)
        return static_cast<double>(*middle);
    return 0.5 * (static_cast<double>(*middle) + static_cast<double>(*std::max_element(sorted.begin(), middle)));
}

double TimeSeries::minimum() const {
    return values_.empty() ? 0.0 : static_cast<double>(*std::ranges::min_element(values_));
}

double TimeSeries::maximum() const {
    return values_.empty() ? 0.0 : static_cast<double>(*std::ranges::max_element(values_));
}

void PassTimes::add(const std::vector<NamedTime>& times) {
    std::vector<Row> rows;
    std::vector<std::pair<std::string, double>> sums;
    for (const NamedTime& time : times) {
        const auto is_same = [&](const Row& row) { return row.group == time.group && row.pass == time.pass; };
        // A pass that runs several times in a frame is one row.
        auto row = std::ranges::find_if(rows, is_same);
        if (row == rows.end()) {
            const auto old = std::ranges::find_if(rows_, is_same);
            rows.push_back(old == rows_.end() ? Row{time.group, time.pass, {}} : *old);
        }
        const auto sum = std::ranges::find(sums, time.group, &std::pair<std::string, double>::first);
        if (sum == sums.end())
            sums.emplace_back(time.group, time.milliseconds);
        else
            sum->second += time.milliseconds;
    }
    for (Row& row : rows) {
        double together = 0.0;
        for (const NamedTime& time : times)
            together += row.group == time.group && row.pass == time.pass ? time.milliseconds : 0.0;
        row.series.add(together);
    }
    std::vector<std::pair<std::string, TimeSeries>> totals;
    for (const auto& [group, sum] : sums) {
        const auto old = std::ranges::find(totals_, group, &std::pair<std::string, TimeSeries>::first);
        totals.emplace_back(group, old == totals_.end() ? TimeSeries{} : old->second);
        totals.back().second.add(sum);
    }
    rows_ = std::move(rows);
    totals_ = std::move(totals);
}

} // namespace sfumato::viewer
