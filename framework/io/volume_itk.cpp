// SPDX-License-Identifier: Apache-2.0
// NRRD, NIfTI, MetaImage and DICOM through ITK's image readers, without its image types: they check
// and convert here what the readers state.
#include "framework/io/dicom_check.hpp"
#include "framework/io/volume_payload.hpp"
#include "framework/io/volume_readers.hpp"

#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <span>
#include <string_view>
#include <utility>

namespace ockham {
namespace {

namespace fs = std::filesystem;
using Io = itk::ImageIOBase;
using Component = itk::IOComponentEnum;

/// Calls `read`, which may throw anything that ITK and what it uses throw.
template <class Function>
auto guarded(const std::string& file, Function read) {
    itk::Object::GlobalWarningDisplayOff();
    try {
        return read();
    } catch (const Error&) {
        throw;
    } catch (const itk::ExceptionObject& error) {
        std::string text = error.GetDescription();
        std::ranges::replace(text, '\n', ' ');
        fail_input("cannot load volume '{}': {}", file, text);
    } catch (const std::bad_alloc&) {
        fail_input("cannot load volume '{}': out of memory", file);
    } catch (const std::exception& error) {
        fail_input("cannot load volume '{}': {}", file, error.what());
    }
}

/// What a header says, checked.
struct Stated {
    glm::uvec3 dims{0};
    Component component = Component::UNKNOWNCOMPONENTTYPE;
    std::size_t component_bytes = 0;
    glm::dvec3 spacing{1}, origin{0};
    glm::dmat3 direction{1.0};

    std::uint64_t bytes() const {
        return std::uint64_t{dims.x} * dims.y * dims.z * component_bytes;
    }
    std::string component_name() const { return Io::GetComponentTypeAsString(component); }
};

Stated state(Io& io, const std::string& file) {
    io.SetFileName(file);
    io.ReadImageInformation();
    if (io.GetNumberOfComponents() != 1) {
        fail_input("cannot load volume '{}': its voxels have {} components ({}), expected 1; save "
                   "one of them, or their length",
            file, io.GetNumberOfComponents(), Io::GetPixelTypeAsString(io.GetPixelType()));
    }
    const unsigned count = io.GetNumberOfDimensions();
    Stated result;
    StatedDims dims{1, 1, 1};
    for (unsigned axis = 0; axis < count; ++axis) {
        if (axis < 3) {
            dims[axis] = io.GetDimensions(axis);
        } else if (io.GetDimensions(axis) != 1) {
            fail_input("cannot load volume '{}': it has {} dimensions, the size of dimension {} is "
                       "{}, expected 3 dimensions; save one of these volumes alone",
                file, count, axis + 1, io.GetDimensions(axis));
        }
    }
    result.dims = checked_dims(file, dims);
    result.component = io.GetComponentType();
    result.component_bytes = io.GetComponentSize();
    for (unsigned axis = 0; axis < std::min(count, 3u); ++axis) {
        const auto a = static_cast<int>(axis);
        result.spacing[a] = io.GetSpacing(axis);
        result.origin[a] = io.GetOrigin(axis);
        const std::vector<double> column = io.GetDirection(axis);
        for (unsigned i = 0; i < std::min<std::size_t>(column.size(), 3); ++i) {
            result.direction[a][static_cast<int>(i)] = column[i];
        }
    }
    return result;
}

/// After state(). `into` has room for the image.
void read_pixels(Io& io, std::byte* into) {
    itk::ImageIORegion all(io.GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
        all.SetSize(axis, io.GetDimensions(axis));
    }
    io.SetIORegion(all);
    io.Read(into);
}

/// Calls `visit` with a value of the C++ type of a component.
template <class Visitor>
auto with_component(Component component, const std::string& file, Visitor visit) {
    switch (component) {
    case Component::UCHAR:
        return visit(std::uint8_t{});
    case Component::CHAR:
        return visit(std::int8_t{});
    case Component::USHORT:
        return visit(std::uint16_t{});
    case Component::SHORT:
        return visit(std::int16_t{});
    case Component::UINT:
        return visit(std::uint32_t{});
    case Component::INT:
        return visit(std::int32_t{});
    case Component::ULONG:
        return visit(static_cast<unsigned long>(0));
    case Component::LONG:
        return visit(static_cast<long>(0));
    case Component::ULONGLONG:
        return visit(static_cast<unsigned long long>(0));
    case Component::LONGLONG:
        return visit(static_cast<long long>(0));
    case Component::FLOAT:
        return visit(float{});
    case Component::DOUBLE:
        return visit(double{});
    default:
        fail_input("cannot load volume '{}': voxels of type {} are not supported, expected "
                   "integers of at most 64 bits, float or double",
            file, Io::GetComponentTypeAsString(component));
    }
}

template <class To, class From>
void convert(std::span<const std::byte> from, std::byte* to) {
    for (std::size_t i = 0; i < from.size() / sizeof(From); ++i) {
        From value;
        std::memcpy(&value, from.data() + i * sizeof(From), sizeof(From));
        const To converted = static_cast<To>(value);
        std::memcpy(to + i * sizeof(To), &converted, sizeof(To));
    }
}

/// int16 or uint16 where that holds all the values, or else float32.
template <class From>
VoxelType narrowest(std::span<const std::byte> values) {
    if constexpr (std::is_integral_v<From>) {
        From low = std::numeric_limits<From>::max(), high = std::numeric_limits<From>::lowest();
        for (std::size_t i = 0; i < values.size(); i += sizeof(From)) {
            From value;
            std::memcpy(&value, values.data() + i, sizeof(From));
            low = std::min(low, value);
            high = std::max(high, value);
        }
        if (std::in_range<std::int16_t>(low) && std::in_range<std::int16_t>(high)) {
            return VoxelType::int16;
        }
        if (std::in_range<std::uint16_t>(low) && std::in_range<std::uint16_t>(high)) {
            return VoxelType::uint16;
        }
    }
    return VoxelType::float32;
}

/// The voxels and type of `volume` from values of `component`.
void set_voxels(
    Volume& volume, std::vector<std::byte>&& values, Component component, const std::string& file) {
    const std::pair<Component, VoxelType> same[] = {{Component::UCHAR, VoxelType::uint8},
        {Component::USHORT, VoxelType::uint16}, {Component::SHORT, VoxelType::int16},
        {Component::FLOAT, VoxelType::float32}};
    for (const auto& [stored, type] : same) {
        if (component != stored) continue;
        volume.type = type;
        volume.voxels = std::move(values);
        return;
    }
    with_component(component, file, [&](auto sample) {
        using From = decltype(sample);
        volume.type = narrowest<From>(values);
        volume.voxels.resize(bytes_of_voxels(volume));
        std::byte* to = volume.voxels.data();
        if (volume.type == VoxelType::int16) convert<std::int16_t, From>(values, to);
        if (volume.type == VoxelType::uint16) convert<std::uint16_t, From>(values, to);
        if (volume.type == VoxelType::float32) convert<float, From>(values, to);
    });
    volume.notes.push_back(fmt::format("its voxels of type {} are kept as {}",
        Io::GetComponentTypeAsString(component), name_of(volume.type)));
}

void set_place(Volume& volume, const Stated& stated) {
    volume.dims = stated.dims;
    volume.spacing_mm = stated.spacing;
    volume.direction = stated.direction;
    volume.origin_mm = stated.origin;
}

Io::Pointer reader_of(const std::string& extension) {
    if (extension == ".nrrd" || extension == ".nhdr") return itk::NrrdImageIO::New().GetPointer();
    if (extension == ".mhd" || extension == ".mha") return itk::MetaImageIO::New().GetPointer();
    return itk::NiftiImageIO::New().GetPointer();
}

// ---- DICOM

struct Slice {
    itk::GDCMImageIO::Pointer io;
    Stated stated;
};

Slice read_slice(const std::string& name) {
    check_dicom(name);
    Slice slice{itk::GDCMImageIO::New(), {}};
    slice.stated = state(*slice.io, name);
    return slice;
}

/// Slices of one series, size and orientation.
struct Series {
    std::string uid;
    std::vector<Slice> slices;
};

std::string uid_of(const Slice& slice) {
    std::string uid;
    itk::ExposeMetaData<std::string>(slice.io->GetMetaDataDictionary(), "0020|000e", uid);
    return uid.substr(0, uid.find_last_not_of(std::string_view("\0 ", 2)) + 1);
}

bool alike(const Stated& a, const Stated& b) {
    return a.dims == b.dims && glm::length(a.direction[0] - b.direction[0]) < 1e-3 &&
           glm::length(a.direction[1] - b.direction[1]) < 1e-3;
}

/// The largest first. Files that are not DICOM are left out.
std::vector<Series> series_of(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.is_regular_file() && is_dicom(entry.path())) files.push_back(entry.path());
    }
    std::ranges::sort(files); // the same on every system
    std::vector<Series> all;
    for (const fs::path& file : files) {
        Slice slice = read_slice(file.string());
        const std::string uid = uid_of(slice);
        auto series = std::ranges::find_if(all, [&](const Series& other) {
            return other.uid == uid && alike(other.slices.front().stated, slice.stated);
        });
        if (series == all.end()) {
            all.push_back({uid, {}});
            series = all.end() - 1;
        }
        series->slices.push_back(std::move(slice));
    }
    std::ranges::stable_sort(
        all, [](const Series& a, const Series& b) { return a.slices.size() > b.slices.size(); });
    return all;
}

/// Puts slices in order along their normal, which the last axis becomes. Notes what is not as it
/// should be.
void place_slices(Volume& volume, std::vector<Slice>& slices, const std::string& file) {
    const glm::dvec3 normal = glm::cross(volume.direction[0], volume.direction[1]);
    std::ranges::stable_sort(slices, [&](const Slice& a, const Slice& b) {
        return glm::dot(a.stated.origin, normal) < glm::dot(b.stated.origin, normal);
    });
    const auto origin = [&](std::size_t i) { return slices[i].stated.origin; };
    const auto steps = static_cast<double>(slices.size() - 1);
    const glm::dvec3 step = (origin(slices.size() - 1) - origin(0)) / steps;
    const double along = glm::dot(step, normal);
    double least = std::numeric_limits<double>::max(), most = 0;
    for (std::size_t i = 1; i < slices.size(); ++i) {
        const double distance = glm::dot(origin(i) - origin(i - 1), normal);
        least = std::min(least, distance);
        most = std::max(most, distance);
        if (!(distance > 1e-4)) {
            fail_input("cannot load volume '{}': slices {} and {} are {} mm apart, expected "
                       "different places; the series holds several volumes or no positions: load "
                       "one of them alone",
                file, i, i + 1, distance);
        }
    }
    volume.spacing_mm.z = along;
    volume.direction[2] = normal;
    volume.origin_mm = origin(0);
    if (most - least > 0.01 * volume.spacing_mm.z) {
        volume.notes.push_back(fmt::format("its slices are {} to {} mm apart; the mean, {} mm, is "
                                           "taken for all",
            least, most, volume.spacing_mm.z));
    }
    if (const double tilt = glm::degrees(std::acos(std::min(1.0, along / glm::length(step))));
        tilt > 0.1) {
        volume.notes.push_back(
            fmt::format("its gantry tilt of {:.1f} degrees is not honoured", tilt));
    }
}

Volume load_slices(std::vector<Slice> slices, const std::string& file) {
    const Stated first = slices.front().stated; // a copy: slices are put in order below
    Volume volume;
    set_place(volume, first);
    if (volume.dims.z == 1 && slices.size() == 1) {
        volume.notes.push_back(
            fmt::format("a single slice, taken to be {} mm thick", volume.spacing_mm.z));
    }
    if (slices.size() > 1) {
        if (first.dims.z != 1) {
            fail_input("cannot load volume '{}': its series has {} files of {} slices each; load "
                       "one of the files alone",
                file, slices.size(), first.dims.z);
        }
        volume.dims = checked_dims(file, {first.dims.x, first.dims.y, slices.size()});
        place_slices(volume, slices, file);
    }

    // Slices with a rescale of their own may differ in type.
    const bool same = std::ranges::all_of(
        slices, [&](const Slice& slice) { return slice.stated.component == first.component; });
    const std::size_t bytes = same ? first.component_bytes : sizeof(float);
    const std::size_t slice_bytes = volume.voxel_count() / slices.size() * bytes;
    std::vector<std::byte> values(slice_bytes * slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) {
        std::byte* into = values.data() + i * slice_bytes;
        if (same) {
            read_pixels(*slices[i].io, into);
            continue;
        }
        std::vector<std::byte> pixels(slices[i].stated.bytes());
        read_pixels(*slices[i].io, pixels.data());
        with_component(slices[i].stated.component, file,
            [&](auto sample) { convert<float, decltype(sample)>(pixels, into); });
    }
    set_voxels(volume, std::move(values), same ? first.component : Component::FLOAT, file);
    return volume;
}

} // namespace

Volume load_itk_volume(const fs::path& path) {
    const std::string file = path.string();
    return guarded(file, [&] {
        std::string extension = path.extension().string();
        std::ranges::transform(extension, extension.begin(),
            [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        check_references(path);
        const Io::Pointer io = reader_of(extension);
        const Stated stated = state(*io, file);
        Volume volume;
        set_place(volume, stated);
        check_payload(path,
            {volume.voxel_count(), stated.bytes(),
                fmt::format("{} x {} x {} voxels of type {}", stated.dims.x, stated.dims.y,
                    stated.dims.z, stated.component_name())},
            volume.notes);
        std::vector<std::byte> values(stated.bytes());
        read_pixels(*io, values.data());
        set_voxels(volume, std::move(values), stated.component, file);
        return volume;
    });
}

Volume load_dicom_volume(const fs::path& path, const std::string& wanted) {
    const std::string file = path.string();
    return guarded(file, [&] {
        if (!fs::is_directory(path)) {
            if (!is_dicom(path)) {
                fail_input("cannot load volume '{}': the mark DICM is not at byte 128; it is no "
                           "DICOM file",
                    file);
            }
            std::vector<Slice> slices;
            slices.push_back(read_slice(file));
            return load_slices(std::move(slices), file);
        }
        std::vector<Series> all = series_of(path);
        std::vector<std::string> names, notes;
        // Sizes and orientations of the same UID get a number from the second on.
        std::map<std::string, int> parts;
        for (const Series& series : all) {
            const int part = ++parts[series.uid];
            names.push_back(part == 1 ? series.uid : fmt::format("{}-{}", series.uid, part));
        }
        Series& chosen = all[choose_part(file, "DICOM series", names, wanted, notes)];
        Volume volume = load_slices(std::move(chosen.slices), file);
        volume.notes.insert(volume.notes.begin(), notes.begin(), notes.end());
        return volume;
    });
}

} // namespace ockham
