// The elements of a PLY file row by row, for readers to whom lists are of no use.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "splat/io/ply_header.h"
#include "splat/io/ply_numbers.h"
#include "splat/result.h"

namespace swept {

/// Whether the file can hold the element's rows: what is read or reserved for them is backed by its bytes.
[[nodiscard]] Status check_ply_size(const std::string& path, const PlyElement& element,
                                    const PlyNumbers& numbers);

/// What is to be done with the numbers of a row, one per property; 0 stands for lists.
using PlyRow = std::function<Status(std::span<const double> numbers)>;

/// Reads the element's rows, of which check_ply_size() holds. Errors: as `row`, and rows that are cut short
/// or hold what is no number, with property and row.
[[nodiscard]] Status read_ply_rows(const std::string& path, const PlyElement& element, PlyNumbers& numbers,
                                   const PlyRow& row);

}  // namespace swept
