#include "server/scene/load/image_loader.h"

#include "server/base/error.h"
#include "server/images/image_module.h"
#include "server/images/picture_reader.h"
#include "server/images/radiance_header.h"
#include "server/scene/load/file_folder.h"

namespace heliograph {

namespace {

constexpr uint32_t LONGEST_SIDE = 16384;
constexpr int64_t MOST_PIXELS = int64_t(128) << 20;
constexpr uint64_t BUDGET_BASE = uint64_t(192) << 20;
constexpr uint64_t BUDGET_PER_BYTE = 100;

/// A format that we read: how its files begin, and who reads it: two functions of ours, or the picture module by its name for
/// the format.
struct Format {
    std::string_view magic;
    PictureSize (*readSize)(std::span<const uint8_t>);
    void (*read)(std::span<const uint8_t>, std::span<uint8_t>);
    const char* moduleReader;
    bool hdr = false;
    std::string_view atEight = {};  // what stands at byte 8, too
};
constexpr Format FORMATS[] = {
    {"\x89PNG\r\n\x1a\n", readPngSize, readPng, nullptr},
    {"\xff\xd8\xff", readJpegSize, readJpeg, nullptr},
    {std::string_view("\x76\x2f\x31\x01", 4), nullptr, nullptr, "openexr", true},
    {"#?", nullptr, nullptr, "hdr", true},
    {"RIFF", readWebpSize, readWebp, nullptr, false, "WEBP"},
};

/// By content, never by the file's name.
const Format& formatOf(std::span<const uint8_t> file, const std::string& name) {
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    for (const Format& format : FORMATS) {
        if (bytes.substr(0, format.magic.size()) != format.magic) continue;
        if (format.atEight.empty() || (bytes.size() > 12 && bytes.substr(8, format.atEight.size()) == format.atEight))
            return format;
    }
    const bool ktx = bytes.size() > 6 && bytes.substr(1, 5) == "KTX 2";
    throw InputError(name, ktx ? "a KTX2 picture, which no reader here knows" : "unknown image format",
                     "PNG, JPEG, WebP, Radiance HDR or OpenEXR");
}

/// One call of a reader. `what` stands before its fault.
template <typename Work>
void attempt(const std::string& name, const char* what, const Work& work) {
    try {
        work();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw InputError(name, std::string(what) + ": " + std::string(error.what()).substr(0, 200));
    }
}

template <typename Function, typename... Arguments>
void callModule(Function function, Arguments... arguments) {
    char message[IMAGE_MESSAGE_BYTES];
    if (!function(arguments..., message)) throw std::runtime_error(message);
}

void check(const ImageHeader& header, const std::string& name) {
    const int64_t width = header.width, height = header.height;
    if (width < 1 || height < 1 || width > LONGEST_SIDE || height > LONGEST_SIDE || width * height > MOST_PIXELS) {
        throw InputError(
            name, std::to_string(width) + " x " + std::to_string(height) + " pixels",
            "sides of 1 to " + std::to_string(LONGEST_SIDE) + ", at most " + std::to_string(MOST_PIXELS) + " pixels");
    }
    if (header.channels < 1 || header.channels > 16 || !header.flat)
        throw InputError(name, "a deep image, a volume, or one of " + std::to_string(header.channels) + " channels",
                         "a flat image of 1 to 16 channels");
}

/// A picture of which the header was read and found good.
struct CheckedImage {
    const Format& format;
    const ImageModule* module;
    ImageFile file;
    ImageHeader header{};
    RadianceHeader radiance;     // of such a picture
    std::vector<uint8_t> plain;  // the same as OpenImageIO reads it; empty before it is asked for

    bool isRadiance() const { return format.hdr && format.moduleReader == std::string_view("hdr"); }

    CheckedImage(std::span<const uint8_t> bytes, const std::string& name)
        : format(formatOf(bytes, name)),
          module(format.moduleReader ? &imageModule() : nullptr),
          file{bytes.data(), bytes.size(), format.moduleReader} {
        attempt(name, "the image cannot be read", [&] {
            if (isRadiance()) {
                radiance = readRadianceHeader(bytes);
                header = {static_cast<int32_t>(radiance.perLine), static_cast<int32_t>(radiance.lines), 3, 1};
                return;
            }
            if (module) return callModule(module->readHeader, &file, &header);
            const PictureSize size = format.readSize(bytes);
            header = {static_cast<int32_t>(size.width), static_cast<int32_t>(size.height), 4, 1};
        });
        check(header, name);
    }
};

void spreadToRgb(std::vector<float>& pixels, size_t texels, int channels) {
    if (channels == 3) return;
    pixels.resize(texels * 3);
    for (size_t i = texels; i-- > 0;) {
        const float grey = pixels[i];
        for (int c = 0; c < 3; c++) pixels[i * 3 + c] = grey;
    }
}

void readHdr(CheckedImage& checked, ImageData& image) {
    const size_t texels = size_t(image.width) * image.height;
    const int32_t channels = checked.header.channels >= 3 ? 3 : 1;
    if (checked.isRadiance()) {
        checked.plain = plainRadiance(checked.radiance, {checked.file.bytes, checked.file.size});
        checked.file.bytes = checked.plain.data();
        checked.file.size = checked.plain.size();
    }
    image.rgb32f.resize(texels * static_cast<size_t>(channels));
    callModule(checked.module->readPixels, &checked.file, &checked.header, channels, image.rgb32f.data());
    spreadToRgb(image.rgb32f, texels, channels);
    if (!checked.isRadiance()) return;
    straighten(checked.radiance, image.rgb32f);
    image.width = checked.radiance.width();
    image.height = checked.radiance.height();
}

}  // namespace

ImageInfo inspectImage(std::span<const uint8_t> file, const std::string& name) {
    const CheckedImage checked(file, name);
    const bool turned = checked.isRadiance() && checked.radiance.columns;
    const uint32_t width = static_cast<uint32_t>(checked.header.width), height = static_cast<uint32_t>(checked.header.height);
    return {turned ? height : width, turned ? width : height, checked.format.hdr};
}

ImageData decodeImage(std::span<const uint8_t> file, const std::string& name, bool srgb) {
    CheckedImage checked(file, name);
    ImageData image;
    image.width = static_cast<uint32_t>(checked.header.width);
    image.height = static_cast<uint32_t>(checked.header.height);
    image.srgb = srgb;
    image.name = name;
    attempt(name, "the pixels cannot be decoded", [&] {
        if (checked.format.hdr) readHdr(checked, image);
        else {
            image.rgba8.resize(size_t(image.width) * image.height * 4);
            checked.format.read(file, image.rgba8);
        }
    });
    return image;
}

ImageData loadImage(const std::filesystem::path& path, bool srgb) { return decodeImage(readFile(path), path.string(), srgb); }

void ImageBudget::take(const std::string& name, uint64_t fileBytes, uint64_t decodedBytes) {
    fileBytes_ += fileBytes;
    decodedBytes_ += decodedBytes;
    const uint64_t most = BUDGET_BASE + BUDGET_PER_BYTE * fileBytes_;
    if (decodedBytes_ > most) {
        throw InputError(name, "the images decode to " + std::to_string(decodedBytes_) + " bytes",
                         "at most " + std::to_string(most) + " for files of " + std::to_string(fileBytes_) + " bytes");
    }
}

}  // namespace heliograph
