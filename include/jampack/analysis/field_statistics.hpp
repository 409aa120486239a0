// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <jampack/core/array.hpp>
#include <jampack/core/error.hpp>

namespace jampack {

/// A scalar field sampled at points that stand for weights (volumes), e.g. the von Mises stress of a packing.
struct WeightedField {
  Array<double> values;   ///< finite
  Array<double> weights;  ///< >= 0, the same length, not all zero

  void add(double value, double weight) {
    values.push_back(value);
    weights.push_back(weight);
  }
};

/// Throws InvalidInput unless the field is as WeightedField says.
inline void require_valid(const WeightedField& field) {
  require(field.values.size() == field.weights.size(), "field: needs one weight a value");
  double total = 0;
  for (Index i = 0; i < field.values.size(); ++i) {
    require(std::isfinite(field.values[i]) && field.weights[i] >= 0,
            "field: values must be finite, weights not negative");
    total += field.weights[i];
  }
  require(total > 0 && std::isfinite(total), "field: the weights must have a positive finite sum");
}

struct FieldMoments {
  double mean;
  double standard_deviation;  ///< of the population: no n - 1
};

inline FieldMoments field_moments(const WeightedField& field) {
  require_valid(field);
  double total = 0, sum = 0, square = 0;
  for (Index i = 0; i < field.values.size(); ++i) {
    total += field.weights[i];
    sum += field.weights[i] * field.values[i];
  }
  const double mean = sum / total;
  for (Index i = 0; i < field.values.size(); ++i)
    square += field.weights[i] * (field.values[i] - mean) * (field.values[i] - mean);
  return {mean, std::sqrt(square / total)};
}

/// Standard deviation over mean: of the field normalised by its mean, as in the paper's figure pdf_pe. Zero
/// for a field that is zero everywhere; throws InvalidInput for a mean that is not positive otherwise.
inline double normalised_standard_deviation(const WeightedField& field) {
  const FieldMoments moments = field_moments(field);
  if (moments.standard_deviation == 0) return 0;
  require(moments.mean > 0, "field: only a field of positive mean can be normalised by it");
  return moments.standard_deviation / moments.mean;
}

/// Probability density of a field over its mean, on equal bins of [0, largest].
struct FieldPdf {
  double bin_width;
  Array<double> centres;  ///< in units of the mean
  Array<double>
      densities;  ///< sum of densities * bin_width is the fraction of the weight within [0, largest]
};

/// Throws InvalidInput for a field without positive mean, fewer than one bin, or largest <= 0.
inline FieldPdf field_pdf(const WeightedField& field, Index n_bins = 50, double largest = 5) {
  const double mean = field_moments(field).mean;
  require(mean > 0, "field: only a field of positive mean can be normalised by it");
  require(n_bins >= 1 && largest > 0 && std::isfinite(largest), "field_pdf: needs a bin and largest > 0");
  FieldPdf pdf{largest / static_cast<double>(n_bins), Array<double>(n_bins), Array<double>(n_bins, 0.0)};
  for (Index b = 0; b < n_bins; ++b) pdf.centres[b] = (static_cast<double>(b) + 0.5) * pdf.bin_width;
  double total = 0;
  for (Index i = 0; i < field.values.size(); ++i) {
    total += field.weights[i];
    const double x = field.values[i] / mean;
    if (x < 0 || x > largest) continue;
    const Index bin = std::min(n_bins - 1, static_cast<Index>(x / pdf.bin_width));
    pdf.densities[bin] += field.weights[i];
  }
  for (double& density : pdf.densities) density /= total * pdf.bin_width;
  return pdf;
}

/// The part of a field above a threshold, by the moments of its excess y = x - threshold > 0 (x over the
/// mean of the field). Nothing is binned and nothing is fitted.
struct FieldTail {
  double weight_fraction;  ///< of the field that lies above
  double mean_excess;      ///< <y>: the decay length of an exponential tail
  double shape;            ///< <y^2> / <y>^2: 2 when exponential, pi/2 for a Gaussian cut at its mean, more
                           ///< than 2 when heavier than exponential; 0 when nothing lies above
};

inline FieldTail field_tail(const WeightedField& field, double threshold_over_mean = 1) {
  const double mean = field_moments(field).mean;
  require(mean > 0, "field: only a field of positive mean can be normalised by it");
  double total = 0, above = 0, first = 0, second = 0;
  for (Index i = 0; i < field.values.size(); ++i) {
    total += field.weights[i];
    const double excess = field.values[i] / mean - threshold_over_mean;
    if (excess <= 0) continue;
    above += field.weights[i];
    first += field.weights[i] * excess;
    second += field.weights[i] * excess * excess;
  }
  if (first == 0) return {0, 0, 0};
  return {above / total, first / above, second * above / (first * first)};
}

}  // namespace jampack
