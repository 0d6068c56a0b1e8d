#include "ch5_backend/simulate/city.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/so3.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

constexpr double kBlock = 60.0, kStep = 2.0, kFacade = 8.0, kHeight = 10.0, kEye = 1.5, kFarthest = 30.0,
                 kNearest = 3.0;
constexpr double kMissed = 0.2;  // of the views
constexpr int kFewestViews = 3;

void Validate(const CityOptions& options) {
  CheckOption("CityOptions::cameras", options.cameras, 2);
  CheckPositive("CityOptions::points_per_meter", options.points_per_meter);
  CheckNotNegative("CityOptions::pixel_sigma", options.pixel_sigma);
  CheckNotNegative("CityOptions::position_sigma", options.position_sigma);
  CheckNotNegative("CityOptions::rotation_sigma", options.rotation_sigma);
  CheckNotNegative("CityOptions::point_sigma", options.point_sigma);
}

// A place on a street, and where the street leads.
struct Place {
  Vec3 p, direction;
  Vec3 Left() const { return Vec3::UnitZ().cross(direction); }
};

// The car's way through n + 1 streets of n blocks, each way.
class Drive {
 public:
  // The smallest city in which `cameras` steps fit. Turned by 30°, no camera's ‖ω‖ is near π.
  explicit Drive(int cameras) : turn_(ExpSO3(Vec3(0.0, 0.0, M_PI / 6.0))) {
    while (2 * (blocks_ + 1) * StepsPerStreet() < cameras) ++blocks_;
  }
  int StepsPerStreet() const { return blocks_ * static_cast<int>(kBlock / kStep); }
  Place At(int step) const {
    const int street = step / StepsPerStreet(), row = street % (blocks_ + 1);
    const bool is_back = row % 2 == 1, is_north = street > blocks_;
    const double done = kStep * (step % StepsPerStreet()), length = kBlock * blocks_;
    Vec3 p(is_back ? length - done : done, kBlock * row, kEye), direction(is_back ? -1.0 : 1.0, 0.0, 0.0);
    if (is_north) std::swap(p.x(), p.y()), std::swap(direction.x(), direction.y());
    return {turn_ * p, turn_ * direction};
  }

 private:
  Qd turn_;
  int blocks_ = 1;
};

struct FacadePoint {
  Vec3 p, normal;  // the normal points to the street
};

// Those of each step's piece of street.
std::vector<FacadePoint> MakePoints(const Drive& drive, const CityOptions& options, Random* random) {
  std::vector<FacadePoint> points;
  double wanted = 0.0;
  for (int step = 0; step < options.cameras; ++step) {
    const Place place = drive.At(step);
    for (wanted += options.points_per_meter * kStep; wanted >= 1.0; wanted -= 1.0) {
      const double side = random->Bits() % 2 == 0 ? 1.0 : -1.0, along = random->Uniform(0.0, kStep);
      const double up = random->Uniform(0.0, kHeight) - kEye;
      const Vec3 p = place.p + along * place.direction + side * kFacade * place.Left() + up * Vec3::UnitZ();
      points.push_back({p, -side * place.Left()});
    }
  }
  return points;
}

// Points by the square of the ground in which they lie, so that a camera asks its surroundings alone.
class Squares {
 public:
  explicit Squares(const std::vector<FacadePoint>& points) {
    for (size_t k = 0; k < points.size(); ++k) squares_[Of(points[k].p)].push_back(static_cast<int>(k));
  }
  // In ascending order.
  std::vector<int> Around(const Vec3& p) const {
    std::vector<int> found;
    const auto [x, y] = Of(p);
    for (int i = x - 1; i <= x + 1; ++i) {
      for (int j = y - 1; j <= y + 1; ++j) {
        const auto square = squares_.find({i, j});
        if (square != squares_.end()) found.insert(found.end(), square->second.begin(), square->second.end());
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  using Square = std::pair<int, int>;
  static Square Of(const Vec3& p) {
    return {static_cast<int>(std::floor(p.x() / kFarthest)), static_cast<int>(std::floor(p.y() / kFarthest))};
  }
  std::map<Square, std::vector<int>> squares_;
};

// X_C = Exp(ω) X_W + t; the axes of C are right, up and back.
Vec9 CameraAt(const Place& place, Random* random) {
  Mat33 R;
  R << -place.Left().transpose(), Vec3::UnitZ().transpose(), -place.direction.transpose();
  Vec9 camera;
  camera << LogSO3(Qd(R)), -R * place.p, 0.0, 0.0, 0.0;
  camera[6] = random->Uniform(480.0, 520.0);
  camera[7] = random->Uniform(-0.05, 0.0);
  camera[8] = random->Uniform(0.0, 0.01);
  return camera;
}

// The projection of types/bal/edge_bal.h.
Vec2 Project(const Vec9& camera, const Vec3& P) {
  const Vec2 p = -P.head<2>() / P.z();
  const double n = p.squaredNorm();
  return camera[6] * (1.0 + n * (camera[7] + n * camera[8])) * p;
}

void Observe(const std::vector<Place>& places, const std::vector<FacadePoint>& points, double sigma, Random* random,
             City* city) {
  const Squares squares(points);
  for (size_t i = 0; i < places.size(); ++i) {
    const Vec9& camera = city->cameras[i];
    const Mat33 R = ExpSO3(camera.head<3>()).toRotationMatrix();
    for (const int k : squares.Around(places[i].p)) {
      const FacadePoint& point = points[static_cast<size_t>(k)];
      const Vec3 P = R * point.p + camera.segment<3>(3);
      const double depth = -P.z();
      const bool in_view = depth > kNearest && P.norm() < kFarthest && P.head<2>().cwiseAbs().maxCoeff() < depth;
      if (!in_view || point.normal.dot(places[i].p - point.p) <= 0.0 || random->Uniform() < kMissed) continue;
      city->start.observations.push_back({static_cast<int>(i), k, Project(camera, P) + NormalVector<2>(random, sigma)});
    }
  }
}

// Keeps the points with enough views, which take new numbers.
void KeepSeenPoints(const std::vector<FacadePoint>& points, City* city) {
  std::vector<int> number(points.size(), 0);
  std::vector<BalObservation>& observations = city->start.observations;
  for (const BalObservation& seen : observations) ++number[static_cast<size_t>(seen.point)];
  for (size_t k = 0; k < points.size(); ++k) {
    const bool enough = number[k] >= kFewestViews;
    number[k] = enough ? static_cast<int>(city->points.size()) : -1;
    if (enough) city->points.push_back(points[k].p);
  }
  for (BalObservation& seen : observations) seen.point = number[static_cast<size_t>(seen.point)];
  observations.erase(std::remove_if(observations.begin(), observations.end(),
                                    [](const BalObservation& seen) { return seen.point < 0; }),
                     observations.end());
  observations.shrink_to_fit();
}

void Disturb(const std::vector<Place>& places, const CityOptions& options, Random* random, City* city) {
  for (size_t i = 0; i < places.size(); ++i) {
    Vec9 camera = city->cameras[i];
    const Qd q = ExpSO3(camera.head<3>()) * ExpSO3(NormalVector(random, options.rotation_sigma));
    camera.head<3>() = LogSO3(q);
    camera.segment<3>(3) = -(q * (places[i].p + NormalVector(random, options.position_sigma)));
    city->start.cameras.push_back(camera);
  }
  for (const Vec3& point : city->points)
    city->start.points.emplace_back(point + NormalVector(random, options.point_sigma));
}

}  // namespace

City SimulateCity(const CityOptions& options) {
  Validate(options);
  Random random(options.seed);
  City city;
  const Drive drive(options.cameras);
  std::vector<Place> places;
  for (int i = 0; i < options.cameras; ++i) {
    places.push_back(drive.At(i));
    city.cameras.push_back(CameraAt(places.back(), &random));
  }
  const std::vector<FacadePoint> points = MakePoints(drive, options, &random);
  Observe(places, points, options.pixel_sigma, &random, &city);
  KeepSeenPoints(points, &city);
  Disturb(places, options, &random, &city);
  return city;
}

}  // namespace ch5
