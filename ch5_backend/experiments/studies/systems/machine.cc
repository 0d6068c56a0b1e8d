#include <algorithm>
#include <ctime>
#include <fstream>
#include <thread>

#include "ch5_backend/experiments/studies/systems/system_studies.h"

namespace ch5 {
namespace {

// "model name : …" of Linux; other systems keep it elsewhere.
std::string NameOfProcessor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const size_t colon = line.find(": ");
    if (line.rfind("model name", 0) != 0 || colon == std::string::npos) continue;
    std::replace(line.begin(), line.end(), ',', ' ');  // a word of a table has none
    return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

CsvTable MachineTable(int, const std::filesystem::path&) {
  double load = 0.0;
  getloadavg(&load, 1);
  const std::time_t now = std::time(nullptr);
  char date[16];
  std::strftime(date, sizeof date, "%F", std::gmtime(&now));
  CsvTable table("processor,cores,load,date");
  table.Row(NameOfProcessor(), std::thread::hardware_concurrency(), load, date);
  return table;
}

}  // namespace ch5
