// The recent times of passes, for figures and small plots.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sfumato::viewer {

// The newest values of one series, the oldest first.
class TimeSeries {
  public:
    static constexpr size_t most = 120;

    void add(double value);
    const std::vector<float>& values() const { return values_; }
    double latest() const { return values_.empty() ? 0.0 : static_cast<double>(values_.back()); }
    double median() const;
    double minimum() const;
    double maximum() const;

  private:
    std::vector<float> values_;
};

struct NamedTime {
    std::string group; // "scene" or an effect
    std::string pass;
    double milliseconds = 0.0;
};

// One series for each pass, in the order in which the passes ran last; passes that no longer run are forgotten.
class PassTimes {
  public:
    struct Row {
        std::string group, pass;
        TimeSeries series;
    };

    void add(const std::vector<NamedTime>& times);
    const std::vector<Row>& rows() const { return rows_; }
    const std::vector<std::pair<std::string, TimeSeries>>& totals() const { return totals_; } // a group each

  private:
    std::vector<Row> rows_;
    std::vector<std::pair<std::string, TimeSeries>> totals_;
};

} // namespace sfumato::viewer
