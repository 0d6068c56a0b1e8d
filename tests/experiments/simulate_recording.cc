/// Writes a simulated recording, for the tests of the programs that read one: simulate_recording FOLDER SECONDS
/// [stereo|circle].

#include <cstdio>
#include <cstdlib>
#include <string>

#include "ch5_backend/files/recording_file.h"
#include "tests/window/simulations.h"

int main(int argc, char** argv) {
  const bool stereo = argc == 4 && std::string(argv[3]) == "stereo";
  const bool circle = argc == 4 && std::string(argv[3]) == "circle";
  if (argc != 3 && !stereo && !circle)
    return std::fputs("usage: simulate_recording FOLDER SECONDS [stereo|circle]\n", stderr), 2;
  ch5::RoomOptions options;
  options.duration = std::atof(argv[2]);
  options.standstill_seconds = 1.5;
  options.max_tracks = 40;
  if (stereo) options.simulation.calibration = ch5::ForwardStereo();
  ch5::WriteRecording(circle ? ch5::SimulateCircle(options.duration) : ch5::SimulateRoom(options), argv[1]);
}
