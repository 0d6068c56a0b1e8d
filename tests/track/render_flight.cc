/// Renders a flight through a textured room as a folder in EuRoC's layout: render_flight FOLDER SECONDS [equidistant].
/// With 60 s, ./course run FOLDER is the study of the front end.

#include <cstdio>
#include <cstdlib>

#include "tests/track/lenses.h"

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) return std::fputs("usage: render_flight FOLDER SECONDS [equidistant]\n", stderr), 2;
  ch5::RenderOptions options = argc == 4 ? ch5::WideLens() : ch5::EurocLens();
  options.path.duration = std::atof(argv[2]);
  options.path.standstill_seconds = 1.5;
  ch5::WriteRenderedFlight(options, argv[1]);
}
