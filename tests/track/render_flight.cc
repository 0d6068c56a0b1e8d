/// Renders a flight through a textured room as a folder in EuRoC's layout: render_flight FOLDER SECONDS
/// [equidistant|stereo].
/// With 60 s, ./course run FOLDER is the study of the front end.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/track/lenses.h"

int main(int argc, char** argv) {
  const std::string kind = argc == 4 ? argv[3] : "";
  if (argc < 3 || argc > 4 || (argc == 4 && kind != "equidistant" && kind != "stereo")) {
    return std::fputs("usage: render_flight FOLDER SECONDS [equidistant|stereo]\n", stderr), 2;
  }
  ch5::RenderOptions options = kind == "equidistant" ? ch5::WideLens()
                               : kind == "stereo"    ? ch5::StereoLenses()
                                                     : ch5::EurocLens();
  options.path.duration = std::atof(argv[2]);
  options.path.standstill_seconds = 1.5;
  ch5::WriteRenderedFlight(options, argv[1]);
}
