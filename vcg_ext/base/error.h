// SPDX-License-Identifier: GPL-3.0-only
#pragma once
/// What vcg_ext throws on purpose: what is wrong as data, and as a statement in what(). The class
/// says whose fault it is, the finding which fault, how often and where.

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include "vcg_ext/base/fault.h"

namespace sphere_propagation {

/// Base of all errors below; catch this one to catch them all.
class Error : public std::runtime_error {
 public:
  explicit Error(Finding what)
      : std::runtime_error(statement(what) + "."),
        finding_(std::make_shared<const Finding>(std::move(what))) {}
  /// What is said in words only.
  explicit Error(const std::string& text)
      : std::runtime_error(text),
        finding_(std::make_shared<const Finding>(Finding(Fault::Text).saying(text))) {}

  const Finding& finding() const { return *finding_; }
  Fault fault() const { return finding_->fault; }

 private:
  std::shared_ptr<const Finding> finding_;  // shared: copies of an exception must not throw
};

/// A parameter is outside the range that its header documents, or does not fit the others.
class ParameterError : public Error {
  using Error::Error;
};

/// Arguments that contradict what a header asks for: a program's fault. No filter lets a user get
/// there, so the words alone say what is wrong.
class ArgumentError : public ParameterError {
 public:
  explicit ArgumentError(const std::string& text) : ParameterError(text) {}
};

/// What a number must be. Never infinite or NaN.
struct Range {
  double low = 0;
  double high = std::numeric_limits<double>::infinity();
  bool withoutLow = false;

  static Range between(double low, double high) { return {low, high, false}; }
  static Range atLeast(double low) { return {low, std::numeric_limits<double>::infinity(), false}; }
  static Range above(double low) { return {low, std::numeric_limits<double>::infinity(), true}; }
  bool holds(double value) const {
    return std::isfinite(value) && value <= high && (withoutLow ? value > low : value >= low);
  }
};

/// A number is outside its range; name: what it is, in words, as "area weight".
class RangeError : public ParameterError {
 public:
  RangeError(const std::string& name, double value, const Range& range)
      : ParameterError(Finding(range.withoutLow         ? Fault::NotAbove
                               : std::isinf(range.high) ? Fault::TooSmall
                                                        : Fault::NotBetween,
                               name)
                           .at(value, range.low, range.high)) {}
};

/// Throws RangeError where the number is outside the range.
inline void requireRange(const std::string& name, double value, const Range& range) {
  if (!range.holds(value)) throw RangeError(name, value, range);
}

/// A mesh is not a closed surface of genus 0.
class SurfaceError : public Error {
  using Error::Error;
};

/// Positions on the sphere are no valid map, or no valid map could be reached.
class MapError : public Error {
  using Error::Error;
};

/// A label volume cannot be read, or holds no surface.
class VolumeError : public Error {
  using Error::Error;
};

/// A label that was asked for occurs nowhere in a label volume.
class AbsentLabelError : public VolumeError {
  using VolumeError::VolumeError;
};

/// A file cannot be written; nothing was changed in what was there before.
class ExportError : public Error {
  using Error::Error;
};

/// A file of anchors cannot be read, or anchors contradict each other.
class AnchorError : public Error {
  using Error::Error;
};

/// A map cannot be handed from one surface to another.
class PropagationError : public Error {
  using Error::Error;
};

}  // namespace sphere_propagation
