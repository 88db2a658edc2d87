#pragma once

#include <cstdint>
#include <vector>

#include "extperfc/navigate/cost_grid.hpp"

namespace extperfc::benchmark {

/// Exact shortest paths of any angle between corners of cells, for a point that must not enter cells of
/// kInscribedCost or more. A* over the convex corners of what is blocked; what a corner sees is found row by
/// row as intervals (as Anya does, Harabor et al. 2016), only in directions in which a shortest path may bend
/// there. Paths may pass between two blocked cells that touch at a corner, so lengths are lower bounds for a
/// planner that does not.
class ShortestPath {
 public:
  explicit ShortestPath(const navigate::CostGrid& costs);

  struct Vertex {
    int x;  ///< corner of cells: 0 to width
    int y;
  };
  /// [m]; infinite when not connected.
  [[nodiscard]] double length_m(Vertex start, Vertex goal);

 private:
  struct Entry {
    double bound;
    double reached;  ///< length up to the root
    Vertex root;
    int step;  ///< 0: the root itself; else the direction of the rows
    int row;
    double low;
    double high;
    bool operator<(const Entry& other) const { return bound > other.bound; }
  };
  struct Found {
    double length;
    Vertex from;
    bool done;
  };

  [[nodiscard]] bool blocked(int column, int row) const {
    if (column < 0 || row < 0 || column >= width_ || row >= height_) return true;
    return blocked_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(column)] != 0;
  }
  [[nodiscard]] std::size_t index(Vertex v) const {
    return static_cast<std::size_t>(v.y) * static_cast<std::size_t>(width_ + 1) +
           static_cast<std::size_t>(v.x);
  }
  [[nodiscard]] bool is_corner(Vertex v) const { return corner_[index(v)] != 0; }
  void reach(Vertex v, double length, Vertex from);
  void look_around(const Entry& entry);
  void look(Vertex root, double reached, int step, double low, double high);
  void slide(Vertex root, double reached, int direction);
  void go_on(const Entry& entry);
  void add(Vertex root, double reached, int step, int row, double low, double high);

  int width_;
  int height_;
  double resolution_m_;
  std::vector<std::uint8_t> blocked_;
  std::vector<std::uint8_t> corner_;
  std::vector<Found> found_;
  std::vector<std::size_t> touched_;
  std::vector<Entry> open_;  ///< a heap
  Vertex goal_{0, 0};
};

}  // namespace extperfc::benchmark
