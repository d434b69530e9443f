// MRPT's CGridMapAligner as a program of `rectbench run --method-command`: two images in, the placement of B on A out.
//
// Usage: grid_map_aligner A.png B.png [SCALE]
//
// SCALE is cells of A per cell of B, by which B is resampled first; without it both maps are taken as they are, since
// the aligner knows no scale. Grey is read as map_server writes it: 254 free, 205 unknown, 0 occupied. The last line is
// the 2x3 matrix from B's pixel centres to A's, row by row, and the goodness; or the word "rejected".

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

#include <mrpt/img/CImage.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/poses/CPosePDFSOG.h>
#include <mrpt/random.h>
#include <mrpt/slam/CGridMapAligner.h>

namespace {

constexpr float kCellM = 0.05F;  // the aligner's numbers are in metres: a usual size of cells, for images tell none
constexpr std::uint32_t kSeed = 0;

// A map with its size in pixels.
struct Map {
  mrpt::maps::CMultiMetricMap layers;
  int width;
  int height;
};

float free_probability(std::uint8_t grey) {
  if (grey == 0) return 0.0F;
  return grey == 254 ? 1.0F : 0.5F;
}

// Read an image as a grid and the points of its walls; pixels grow by `scale`, the nearest one taken.
Map read_map(const std::string& path, double scale) {
  mrpt::img::CImage image;
  if (!image.loadFromFile(path, 0)) throw std::runtime_error(path + ": cannot be read as an image");
  const int width = std::max(1, static_cast<int>(std::lround(image.getWidth() * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(image.getHeight() * scale)));

  auto grid = mrpt::maps::COccupancyGridMap2D::Create();
  grid->setSize(0.0F, width * kCellM, 0.0F, height * kCellM, kCellM);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const int from_u = std::clamp(static_cast<int>((u + 0.5) / scale), 0, static_cast<int>(image.getWidth()) - 1);
      const int from_v = std::clamp(static_cast<int>((v + 0.5) / scale), 0, static_cast<int>(image.getHeight()) - 1);
      grid->setCell(u, height - 1 - v, free_probability(image.at<std::uint8_t>(from_u, from_v)));  // y is up
    }
  }
  auto walls = mrpt::maps::CSimplePointsMap::Create();
  grid->getAsPointCloud(*walls);

  Map map{{}, width, height};
  map.layers.maps.push_back(grid);
  map.layers.maps.push_back(walls);
  return map;
}

// Print the placement as a matrix between pixel centres: (u, v) lies at ((u + 0.5) cell, (height - v - 0.5) cell).
void print_answer(const mrpt::poses::CPose2D& b_to_a, const Map& a, const Map& b, double scale, double goodness) {
  const double c = std::cos(b_to_a.phi());
  const double s = std::sin(b_to_a.phi());
  const double x0 = 0.5 * scale;  // of pixel (0, 0) of B, in cells
  const double y0 = b.height - 0.5 * scale;
  const double tu = c * x0 - s * y0 + b_to_a.x() / kCellM - 0.5;
  const double tv = a.height - 0.5 - (s * x0 + c * y0 + b_to_a.y() / kCellM);
  std::printf("%.9g %.9g %.9g %.9g %.9g %.9g %.6g\n", scale * c, scale * s, tu, -scale * s, scale * c, tv,
              std::clamp(goodness, 0.0, 1.0));
}

int run(int argc, char** argv) {
  if (argc != 3 && argc != 4) throw std::runtime_error("usage: grid_map_aligner A.png B.png [SCALE]");
  const double scale = argc == 4 ? std::atof(argv[3]) : 1.0;
  if (!(scale > 0.0)) throw std::runtime_error(std::string("SCALE must be > 0, got ") + argv[3]);
  const Map a = read_map(argv[1], 1.0);
  const Map b = read_map(argv[2], scale);

  mrpt::random::getRandomGenerator().randomize(kSeed);
  std::srand(kSeed);
  mrpt::slam::CGridMapAligner aligner;  // its authors' defaults: modified RANSAC over polar images of corners
  mrpt::slam::CGridMapAligner::TReturnInfo info;
  const auto found = aligner.AlignPDF(&a.layers, &b.layers, mrpt::poses::CPosePDFGaussian(), info);
  const auto modes = std::dynamic_pointer_cast<mrpt::poses::CPosePDFSOG>(found);
  if (!modes || modes->empty()) {
    std::puts("rejected");
    return 0;
  }
  const auto best = std::max_element(modes->begin(), modes->end(),
                                     [](const auto& one, const auto& two) { return one.log_w < two.log_w; });
  print_answer(mrpt::poses::CPose2D(best->mean), a, b, scale, info.goodness);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "grid_map_aligner: %s\n", error.what());
    return 2;
  }
}
