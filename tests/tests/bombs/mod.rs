//! Files that are small, and want to be large.

/// A PNG of `side` x `side` white RGBA pixels, whole and valid: a thousandth of
/// what it decodes to.
pub(crate) fn png(side: u32) -> Vec<u8> {
    let mut header = Vec::new();
    header.extend(side.to_be_bytes());
    header.extend(side.to_be_bytes());
    // 8 bits, RGBA, deflate, no interlace.
    header.extend([8, 6, 0, 0, 0]);
    let row = 1 + 4 * u64::from(side);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    chunk(&mut file, b"IHDR", &header);
    chunk(&mut file, b"IDAT", &zlib_of_zeros(row * u64::from(side)));
    chunk(&mut file, b"IEND", &[]);
    file
}

fn chunk(file: &mut Vec<u8>, name: &[u8; 4], content: &[u8]) {
    file.extend((content.len() as u32).to_be_bytes());
    let from = file.len();
    file.extend(name);
    file.extend(content);
    file.extend(crc(&file[from..]).to_be_bytes());
}

fn crc(bytes: &[u8]) -> u32 {
    let table: Vec<u32> = (0..256)
        .map(|n| {
            (0..8).fold(n, |c, _| {
                if c & 1 == 1 {
                    0xedb8_8320 ^ (c >> 1)
                } else {
                    c >> 1
                }
            })
        })
        .collect();
    !bytes.iter().fold(!0, |c, &byte| {
        table[((c ^ u32::from(byte)) & 0xff) as usize] ^ (c >> 8)
    })
}

/// Zeros, packed as well as the format can: a zero, then "the last 258 again".
fn zlib_of_zeros(bytes: u64) -> Vec<u8> {
    let mut bits = Bits::default();
    // A last block of fixed codes; the literal 0.
    bits.put(0b1, 1);
    bits.put(0b01, 2);
    bits.put_code(0b0011_0000, 8);
    for _ in 0..(bytes - 1) / 258 {
        bits.put_code(0b1100_0101, 8);
        bits.put_code(0, 5);
    }
    for _ in 0..(bytes - 1) % 258 {
        bits.put_code(0b0011_0000, 8);
    }
    bits.put_code(0, 7);
    let mut stream = vec![0x78, 0x01];
    stream.extend(bits.end());
    // Adler-32 of zeros.
    let sum = ((bytes % 65_521) << 16) | 1;
    stream.extend((sum as u32).to_be_bytes());
    stream
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    held: u32,
    count: u32,
}

impl Bits {
    /// Lowest bit first.
    fn put(&mut self, value: u32, bits: u32) {
        self.held |= value << self.count;
        self.count += bits;
        while self.count >= 8 {
            self.bytes.push(self.held as u8);
            self.held >>= 8;
            self.count -= 8;
        }
    }

    /// Huffman codes go highest bit first.
    fn put_code(&mut self, code: u32, bits: u32) {
        self.put(code.reverse_bits() >> (32 - bits), bits);
    }

    fn end(mut self) -> Vec<u8> {
        self.put(0, 7);
        self.bytes
    }
}

/// The head of an EXR file of 2^30 x 2^30 pixels.
pub(crate) fn exr() -> Vec<u8> {
    let mut file = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        file.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        file.extend((value.len() as u32).to_le_bytes());
        file.extend(value);
    };
    let mut channels = Vec::new();
    for name in [b"B\0", b"G\0", b"R\0"] {
        channels.extend(name);
        // Float, not linear, every pixel.
        for number in [2u32, 0, 1, 1] {
            channels.extend(number.to_le_bytes());
        }
    }
    channels.push(0);
    let side = (1i32 << 30) - 1;
    let window: Vec<u8> = [0, 0, side, side]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    attribute("channels", "chlist", &channels);
    attribute("compression", "compression", &[3]);
    attribute("dataWindow", "box2i", &window);
    attribute("displayWindow", "box2i", &window);
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    file.push(0);
    file.resize(file.len() + 4096, 0);
    file
}
