#pragma once
/// What a wrong answer is recognized by: ten numbers that do not reveal the answer, but which two equal answers
/// share. ch5_homework/mistakes/answers.csv has those of the mistakes that have a name.

#include <string>

#include "ch5_backend/math/eigen_types.h"

namespace ch5::homework {

/// Rows, columns, and eight projections of (got − expected) / max|expected| on fixed random directions, as a JSON array; of
/// `got` alone if the sizes differ. "" where something is not finite: then the memory speaks, not the mistake.
std::string Fingerprint(const MatXX& expected, const MatXX& got);

/// The same of words: letters count by their codes, and the numbers among them by their values, so that a last digit that
/// another compiler rounds otherwise changes nothing.
std::string Fingerprint(const std::string& expected, const std::string& got);

}  // namespace ch5::homework
