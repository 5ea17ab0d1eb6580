/* SPDX-License-Identifier: Apache-2.0 */
#include "vtk/vtk_export.h"

extern "C" {
#include "base/error.h"
#include "base/file.h"
}

#include <cerrno>
#include <cmath>
#include <exception>
#include <fstream>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkErrorCode.h>
#include <vtkFloatArray.h>
#include <vtkLogger.h>
#include <vtkMeshQuality.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkTypeInt32Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

namespace
{

// Takes what VTK has to say, in place of standard error.
class message_window : public vtkOutputWindow
{
  public:
    static message_window *New();
    vtkTypeMacro(message_window, vtkOutputWindow) void DisplayText(const char *) override {}
    void DisplayErrorText(const char *text) override
    {
        if (error.empty() && text)
            error = text;
    }
    std::string error; // the first
};
vtkStandardNewMacro(message_window)

    class message_catcher
{
  public:
    message_catcher() : before(vtkOutputWindow::GetInstance())
    {
        vtkOutputWindow::SetInstance(window);
        vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
    }
    ~message_catcher() { vtkOutputWindow::SetInstance(before); }
    message_catcher(const message_catcher &) = delete;
    message_catcher &operator=(const message_catcher &) = delete;
    const std::string &error() const { return window->error; }

  private:
    vtkSmartPointer<vtkOutputWindow> before;
    vtkNew<message_window> window;
};

// -- from plain arrays to VTK's, which borrow the memory
// ---------------------------------------------

template <class Array>
vtkSmartPointer<vtkDataArray> borrow(const void *data, size_t count, int width)
{
    auto array = vtkSmartPointer<Array>::New();
    array->SetNumberOfComponents(width);
    array->SetVoidArray(const_cast<void *>(data), static_cast<vtkIdType>(count) * width,
                        1); // 1: VTK is not to free it
    return array;
}

vtkSmartPointer<vtkDataArray> make_array(const struct vtk_array &from, size_t count)
{
    const int width = static_cast<int>(from.width);
    vtkSmartPointer<vtkDataArray> array;
    switch (from.type) {
    case VTK_EXPORT_F32: array = borrow<vtkFloatArray>(from.data, count, width); break;
    case VTK_EXPORT_F64: array = borrow<vtkDoubleArray>(from.data, count, width); break;
    case VTK_EXPORT_I32: array = borrow<vtkTypeInt32Array>(from.data, count, width); break;
    case VTK_EXPORT_U8: array = borrow<vtkUnsignedCharArray>(from.data, count, width); break;
    }
    array->SetName(from.name);
    for (int k = 0; from.components && k < width; k++)
        array->SetComponentName(k, from.components[k]);
    return array;
}

void add_arrays(vtkFieldData *to, const struct vtk_array *arrays, size_t array_count, size_t count)
{
    for (size_t i = 0; i < array_count; i++)
        to->AddArray(make_array(arrays[i], count));
}

vtkSmartPointer<vtkCellArray> make_cells(const struct vtk_mesh *mesh, int corners)
{
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    if (mesh->cell_count) {
        const size_t count = mesh->cell_count * static_cast<size_t>(corners);
        cells->SetData(corners, borrow<vtkTypeInt32Array>(mesh->vertex, count, 1));
        return cells;
    }
    vtkNew<vtkTypeInt32Array> itself;
    itself->SetNumberOfValues(static_cast<vtkIdType>(mesh->point_count));
    for (vtkIdType i = 0; i < itself->GetNumberOfValues(); i++)
        itself->SetValue(i, static_cast<int32_t>(i));
    cells->SetData(1, itself);
    return cells;
}

void fill(vtkPointSet *data, const struct vtk_mesh *mesh)
{
    vtkNew<vtkPoints> points;
    points->SetData(borrow<vtkDoubleArray>(mesh->position, mesh->point_count, 3));
    data->SetPoints(points);
    add_arrays(data->GetPointData(), mesh->point_arrays, mesh->point_array_count,
               mesh->point_count);
    if (mesh->cell_count)
        add_arrays(data->GetCellData(), mesh->cell_arrays, mesh->cell_array_count,
                   mesh->cell_count);
    for (size_t i = 0; i < mesh->text_count; i++) {
        vtkNew<vtkStringArray> text;
        text->SetName(mesh->texts[i].name);
        for (size_t k = 0; k < mesh->texts[i].line_count; k++)
            text->InsertNextValue(mesh->texts[i].lines[k]);
        data->GetFieldData()->AddArray(text);
    }
}

void add_quality(vtkUnstructuredGrid *grid, const char *name, int corners, int measure)
{
    if (grid->GetCellData()->HasArray(name))
        return;
    vtkNew<vtkUnstructuredGrid> bare; // the filter would pass all arrays on
    bare->CopyStructure(grid);
    vtkNew<vtkMeshQuality> quality;
    quality->SetInputData(bare);
    if (corners == 4)
        quality->SetTetQualityMeasure(measure);
    else
        quality->SetTriangleQualityMeasure(measure);
    quality->Update();
    auto *result =
        vtkDoubleArray::SafeDownCast(quality->GetOutput()->GetCellData()->GetArray("Quality"));
    if (!result)
        throw std::runtime_error(std::string("no quality ") + name);
    for (vtkIdType i = 0; i < result->GetNumberOfValues(); i++)
        if (!std::isfinite(result->GetValue(i))) // of a cell without volume
            result->SetValue(i, 0);
    result->SetName(name);
    grid->GetCellData()->AddArray(result);
}

// -- files
// ---------------------------------------------------------------------------------------------

class output
{
  public:
    ~output() { file_output_abandon(&out); }
    struct file_output out = {};
};

// A file that never fails in the eyes of its writer, as VTK's writers crash on a full disk: what
// does not fit is dropped, and the first error kept.
class patient_file : public std::filebuf
{
  public:
    int number = 0; // errno of the first failure

    void finish()
    {
        if (!close())
            failed();
    }

  protected:
    int_type overflow(int_type c) override
    {
        if (!number && std::filebuf::overflow(c) == traits_type::eof())
            failed();
        return traits_type::not_eof(c);
    }
    std::streamsize xsputn(const char *bytes, std::streamsize count) override
    {
        if (!number && std::filebuf::xsputn(bytes, count) != count)
            failed();
        return count;
    }
    int sync() override
    {
        if (!number && std::filebuf::sync())
            failed();
        return 0;
    }
    pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode mode) override
    {
        return number ? pos_type(0) : sought(std::filebuf::seekoff(offset, from, mode));
    }
    pos_type seekpos(pos_type to, std::ios::openmode mode) override
    {
        return number ? to : sought(std::filebuf::seekpos(to, mode));
    }

  private:
    void failed()
    {
        if (!number)
            number = errno ? errno : EIO;
    }
    pos_type sought(pos_type at)
    {
        if (at != pos_type(off_type(-1)))
            return at;
        failed();
        return 0;
    }
};

// A writer of VTK's that writes into a buffer of ours. VTK knows only files and strings; this takes
// the string's place.
template <class Writer> class into_buffer : public Writer
{
  public:
    static into_buffer *New() { VTK_STANDARD_NEW_BODY(into_buffer); }
    std::streambuf *buffer = nullptr;

  protected:
    int StartFile() override
    {
        this->Stream->rdbuf(buffer);
        return Writer::StartFile();
    }
};

template <class Writer>
struct error *write_into(std::streambuf *buffer, vtkDataSet *data, const char *path,
                         enum vtk_encoding encoding, const message_catcher &messages)
{
    vtkNew<into_buffer<Writer>> writer;
    writer->buffer = buffer;
    writer->WriteToOutputStringOn();
    writer->SetInputDataObject(data);
    writer->SetHeaderTypeToUInt64(); // arrays may have more than 4 GB
    writer->SetDataMode(encoding == VTK_EXPORT_TEXT ? vtkXMLWriter::Ascii : vtkXMLWriter::Binary);
    if (encoding == VTK_EXPORT_COMPRESSED)
        writer->SetCompressorTypeToZLib();
    else
        writer->SetCompressorTypeToNone();
    if (writer->Write() && writer->GetErrorCode() == vtkErrorCode::NoError &&
        messages.error().empty())
        return nullptr;
    return error_new("%s: VTK could not write it (code %lu): %.200s", path, writer->GetErrorCode(),
                     messages.error().c_str());
}

// The file itself takes the bytes where there is one; a pipe or device, where VTK cannot seek, gets
// them from memory.
template <class Writer>
struct error *write(vtkDataSet *data, const char *path, enum vtk_encoding encoding,
                    const message_catcher &messages)
{
    output file;
    struct error *err = file_output_open(&file.out, path, false);
    if (err)
        return err;
    if (!file.out.target) {
        std::stringbuf memory(std::ios::in | std::ios::out | std::ios::binary);
        err = write_into<Writer>(&memory, data, path, encoding, messages);
        char *room;
        const auto count = static_cast<size_t>(memory.pubseekoff(0, std::ios::end, std::ios::out));
        if (!err)
            err = file_output_room(&file.out, count, &room);
        if (err)
            return err;
        memory.pubseekpos(0, std::ios::in);
        memory.sgetn(room, static_cast<std::streamsize>(count));
        file.out.count += count;
        return file_output_finish(&file.out);
    }
    const std::string name = file.out.temporary ? file.out.temporary
                                                : "/proc/self/fd/" + std::to_string(file.out.fd);
    patient_file disk;
    if (!disk.open(name, std::ios::out | std::ios::binary))
        return error_system(errno, "%s", path);
    errno = 0;
    err = write_into<Writer>(&disk, data, path, encoding, messages);
    disk.finish();
    if (!err && disk.number)
        err = error_system(disk.number, "%s", path);
    return err ? err : file_output_finish(&file.out);
}

// Runs f with VTK's messages taken in, and turns exceptions into errors.
template <class Function> struct error *guard(const Function &f) noexcept
{
    try {
        const message_catcher messages;
        return f(messages);
    } catch (const std::bad_alloc &) {
        return error_memory();
    } catch (const std::exception &e) {
        return error_new("VTK: %s", e.what());
    } catch (...) {
        return error_new("VTK threw an unknown exception");
    }
}

} // namespace

extern "C" size_t vtk_type_size(enum vtk_type type)
{
    return type == VTK_EXPORT_U8 ? 1 : type == VTK_EXPORT_F64 ? 8 : 4;
}

extern "C" struct error *vtk_export_grid(const char *path, const struct vtk_mesh *mesh,
                                         enum vtk_encoding encoding)
{
    return guard([=](const message_catcher &messages) {
        vtkNew<vtkUnstructuredGrid> grid;
        fill(grid, mesh);
        static const int kinds[] = {VTK_VERTEX, VTK_VERTEX, VTK_LINE, VTK_TRIANGLE, VTK_TETRA};
        const int corners = mesh->cell_count ? mesh->corners : 1;
        grid->SetCells(kinds[corners], make_cells(mesh, corners));
        if (corners >= 3) {
            add_quality(grid, "aspect_ratio", corners, VTK_QUALITY_ASPECT_RATIO);
            add_quality(grid, corners == 4 ? "volume" : "area", corners,
                        corners == 4 ? VTK_QUALITY_VOLUME : VTK_QUALITY_AREA);
        }
        return write<vtkXMLUnstructuredGridWriter>(grid, path, encoding, messages);
    });
}

extern "C" struct error *vtk_export_surface(const char *path, const struct vtk_mesh *mesh,
                                            enum vtk_encoding encoding)
{
    return guard([=](const message_catcher &messages) {
        vtkNew<vtkPolyData> surface;
        fill(surface, mesh);
        surface->SetPolys(make_cells(mesh, 3));
        return write<vtkXMLPolyDataWriter>(surface, path, encoding, messages);
    });
}
