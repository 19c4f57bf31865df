// How long the steps of an import take, one after the other.
#pragma once
#include <chrono>
#include <ctime>
#include <map>
#include <string>

namespace togishi {

struct StepTime {
    double seconds = 0;
    double cpu_seconds = 0;  ///< of all threads of the process
};

/// Runs from its making; each step ends where the next begins.
class StepClock {
  public:
    explicit StepClock(std::map<std::string, StepTime>& time) : time_(time) {}
    void end(const std::string& step) {
        const auto now = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        StepTime& time = time_[step];
        time.seconds += std::chrono::duration<double>(now - start_).count();
        time.cpu_seconds += static_cast<double>(cpu - cpu_start_) / CLOCKS_PER_SEC;
        start_ = now;
        cpu_start_ = cpu;
    }

  private:
    std::map<std::string, StepTime>& time_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::clock_t cpu_start_ = std::clock();
};

}  // namespace togishi
