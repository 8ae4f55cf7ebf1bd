//! The common data representation in which ROS 2 stores messages: four bytes that name the encoding, then fields, each
//! aligned to its size from there on.

/// Reads fields one after the other.
#[derive(Debug)]
pub(super) struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> Cdr<'a> {
    /// Over a message with its encapsulation header. Plain CDR of version 1 alone is known.
    pub(super) fn new(message: &'a [u8]) -> Result<Self, String> {
        let (header, bytes) = message.split_at_checked(4).ok_or("is shorter than its header of 4 bytes")?;
        let big_endian = match header[..2] {
            [0, 0] => true,
            [0, 1] => false,
            [0, 6..=11] => {
                return Err(
                    "is encoded in XCDR2, expected plain CDR, which the default middleware writes".into()
                );
            }
            _ => {
                return Err(format!(
                    "has the encapsulation {:02x} {:02x}, expected 00 00 or 00 01 for plain CDR",
                    header[0], header[1]
                ));
            }
        };
        Ok(Cdr { bytes, at: 0, big_endian })
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        let bytes = self.aligned::<4>()?;
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    pub(super) fn f32(&mut self) -> Result<f32, String> {
        self.u32().map(f32::from_bits)
    }

    pub(super) fn f64(&mut self) -> Result<f64, String> {
        let bytes = self.aligned::<8>()?;
        Ok(if self.big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }

    /// Text that ends in a zero byte, which its length counts; some writers count none for empty text.
    pub(super) fn string(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        let bytes = self.take(length)?;
        Ok(String::from_utf8_lossy(bytes.strip_suffix(&[0]).unwrap_or(bytes)).into_owned())
    }

    /// The length of a sequence, whose items take at least so many bytes each.
    pub(super) fn length(&mut self, item: usize) -> Result<usize, String> {
        let length = self.u32()? as usize;
        let left = self.bytes.len().saturating_sub(self.at);
        if length.saturating_mul(item) > left {
            return Err(format!("announces {length} items and has {left} bytes after that"));
        }
        Ok(length)
    }

    fn aligned<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.at = self.at.next_multiple_of(N);
        let bytes = self.take(N)?;
        bytes.try_into().map_err(|_| self.short())
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(length).ok_or_else(|| self.short())?;
        let bytes = self.bytes.get(self.at..end).ok_or_else(|| self.short())?;
        self.at = end;
        Ok(bytes)
    }

    fn short(&self) -> String {
        format!("ends after {} bytes, in the middle of a field", self.bytes.len() + 4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_aligned_in_either_byte_order() {
        let little = [0, 1, 0, 0, 2, 0, 0, 0, b'a', 0, 9, 9, 0, 0, 0x80, 0x3f, 9, 9, 9, 9];
        let little = [&little[..], &1.5f64.to_le_bytes()].concat();
        let big = [0, 0, 0, 0, 0, 0, 0, 2, b'a', 0, 9, 9, 0x3f, 0x80, 0, 0, 9, 9, 9, 9];
        let big = [&big[..], &1.5f64.to_be_bytes()].concat();
        for message in [little, big] {
            let mut cdr = Cdr::new(&message).unwrap();
            assert_eq!(cdr.string().unwrap(), "a");
            assert_eq!(cdr.f32().unwrap(), 1.0);
            // Twelve bytes behind the header: the next multiple of eight is sixteen.
            assert_eq!(cdr.f64().unwrap(), 1.5);
            assert!(cdr.u32().unwrap_err().starts_with("ends after 28 bytes"));
        }
    }

    #[test]
    fn other_encodings_are_refused() {
        assert!(Cdr::new(&[0, 7, 0, 0]).unwrap_err().contains("XCDR2"));
        assert!(Cdr::new(&[0, 3, 0, 0]).unwrap_err().contains("encapsulation 00 03"));
        assert!(Cdr::new(&[0, 1]).unwrap_err().contains("shorter"));
    }

    #[test]
    fn a_length_beyond_the_message_takes_no_memory() {
        let mut cdr = Cdr::new(&[0, 1, 0, 0, 255, 255, 255, 255, 1]).unwrap();
        assert!(cdr.length(4).unwrap_err().starts_with("announces 4294967295 items"));
        let mut cdr = Cdr::new(&[0, 1, 0, 0, 255, 255, 255, 255, 1]).unwrap();
        assert!(cdr.string().is_err());
    }
}
