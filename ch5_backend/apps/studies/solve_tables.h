#pragma once
/// Tables that every solver run leaves behind.

#include <string>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/world/csv.h"

namespace ch5 {

/// A row for each line of the convergence table, the start included.
CsvTable TraceTable(const Summary& summary);

/// `text` with _ for what a cell cannot hold: commas, quotes and line ends.
std::string CsvWord(std::string text);

}  // namespace ch5
