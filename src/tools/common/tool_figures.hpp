#pragma once

#include <chrono>
#include <filesystem>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start);

/// Processor time of all threads of this process so far [s].
double CpuSeconds();

/// Largest resident set of this process so far [MiB].
double PeakRssMb();

/// 0 for none.
double Median(std::vector<double> values);
double Mean(const std::vector<double>& values);

/// Writes a PNG, whole or not at all.
void WritePng(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace deja_view
