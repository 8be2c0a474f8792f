//! A hand at an X server: it moves the pointer, presses buttons and keys by the extension XTEST, and looks at the screen. It speaks the
//! protocol itself, of which it needs few requests.

use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::thread;
use std::time::{Duration, Instant};

/// The requests of the core protocol.
const QUERY_TREE: u8 = 15;
const SET_INPUT_FOCUS: u8 = 42;
const GET_INPUT_FOCUS: u8 = 43;
const GET_IMAGE: u8 = 73;
const QUERY_EXTENSION: u8 = 98;
/// The one of XTEST, and the kinds of events that it makes.
const FAKE_INPUT: u8 = 2;
const KEY: u8 = 2;
const BUTTON: u8 = 4;
const MOTION: u8 = 6;

/// Keys by their codes: those of a PC keyboard.
pub(crate) const CONTROL: u8 = 37;
pub(crate) const SHIFT: u8 = 50;
pub(crate) const ESCAPE: u8 = 9;
pub(crate) const F: u8 = 41;
pub(crate) const V: u8 = 55;
pub(crate) const Z: u8 = 52;

/// Some frames of the window, even on a busy machine.
const FRAMES: Duration = Duration::from_millis(100);

const PATIENCE: Duration = Duration::from_secs(120);

pub(crate) struct Hand {
    stream: UnixStream,
    root: u32,
    /// The number of XTEST's requests.
    test: u8,
    /// The process that owns the window.
    program: u32,
}

/// A part of the screen.
#[derive(Clone, PartialEq)]
pub(crate) struct Screen {
    pub(crate) width: usize,
    pub(crate) pixels: Vec<[u8; 3]>,
}

impl Screen {
    pub(crate) fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }
}

impl Hand {
    pub(crate) fn new(display: &str, program: u32) -> io::Result<Self> {
        let mut stream = UnixStream::connect(format!("/tmp/.X11-unix/X{display}"))?;
        stream.set_read_timeout(Some(Duration::from_secs(30)))?;
        // Little endian, version 11.0, no name of an authorisation.
        stream.write_all(&[b'l', 0, 11, 0, 0, 0, 0, 0, 0, 0, 0, 0])?;
        let mut head = [0; 8];
        stream.read_exact(&mut head)?;
        let mut setup = vec![0; 4 * usize::from(u16::from_le_bytes([head[6], head[7]]))];
        stream.read_exact(&mut setup)?;
        if head[0] != 1 {
            return Err(io::Error::other("the X server refuses"));
        }
        // Behind the names of the vendor and the formats of pixels comes the first screen.
        let vendor = usize::from(u16::from_le_bytes([setup[16], setup[17]])).next_multiple_of(4);
        let root = number(&setup, 32 + vendor + 8 * usize::from(setup[21]));
        let mut hand = Self { stream, root, test: 0, program };
        let mut ask = vec![QUERY_EXTENSION, 0, 4, 0, 5, 0, 0, 0];
        ask.extend_from_slice(b"XTEST\0\0\0");
        let (answer, _) = hand.ask(&ask)?;
        hand.test = answer[9];
        if answer[8] == 0 { Err(io::Error::other("the X server has no XTEST")) } else { Ok(hand) }
    }

    fn ask(&mut self, request: &[u8]) -> io::Result<([u8; 32], Vec<u8>)> {
        self.stream.write_all(request)?;
        let mut head = [0; 32];
        // Events come between: 0 is an error, 1 the answer.
        while head[0] != 1 {
            self.stream.read_exact(&mut head)?;
            if head[0] == 0 {
                return Err(io::Error::other(format!("the X server refuses: {}", head[1])));
            }
        }
        let mut rest = vec![0; 4 * number(&head, 4) as usize];
        self.stream.read_exact(&mut rest)?;
        Ok((head, rest))
    }

    fn fake(&mut self, kind: u8, detail: u8, [x, y]: [f32; 2]) -> io::Result<()> {
        let mut request = [0; 36];
        request[..6].copy_from_slice(&[self.test, FAKE_INPUT, 9, 0, kind, detail]);
        request[12..16].copy_from_slice(&self.root.to_le_bytes());
        request[24..26].copy_from_slice(&(x.round() as i16).to_le_bytes());
        request[26..28].copy_from_slice(&(y.round() as i16).to_le_bytes());
        self.stream.write_all(&request)?;
        // Waits until the server has done it; then the window has its time.
        self.ask(&[GET_INPUT_FOCUS, 0, 1, 0])?;
        thread::sleep(Duration::from_millis(8));
        Ok(())
    }

    /// Gives the keyboard to the uppermost window, as a manager of windows does.
    pub(crate) fn focus(&mut self) -> io::Result<()> {
        let mut request = [0; 8];
        request[..4].copy_from_slice(&[QUERY_TREE, 0, 2, 0]);
        request[4..].copy_from_slice(&self.root.to_le_bytes());
        let (_, windows) = self.ask(&request)?;
        let window = windows.as_chunks::<4>().0.last().ok_or_else(|| io::Error::other("there is no window"))?;
        let mut request = [0; 12];
        request[..4].copy_from_slice(&[SET_INPUT_FOCUS, 1, 3, 0]);
        request[4..8].copy_from_slice(window);
        self.stream.write_all(&request)
    }

    pub(crate) fn move_to(&mut self, place: [f32; 2]) -> io::Result<()> {
        self.fake(MOTION, 0, place)
    }

    /// Presses and releases buttons: 1 left, 3 right, 4 and 5 the wheel.
    pub(crate) fn press(&mut self, button: u8) -> io::Result<()> {
        self.fake(BUTTON, button, [0.0; 2])
    }

    pub(crate) fn release(&mut self, button: u8) -> io::Result<()> {
        self.fake(BUTTON + 1, button, [0.0; 2])
    }

    pub(crate) fn click(&mut self, place: [f32; 2]) -> io::Result<()> {
        self.move_to(place)?;
        self.press(1)?;
        self.release(1)
    }

    /// Drags with the left button, in steps. The window sees the beginning in frames of its own, as of a person's hand.
    pub(crate) fn drag(&mut self, from: [f32; 2], to: [f32; 2]) -> io::Result<()> {
        self.move_to(from)?;
        self.rest(FRAMES)?;
        self.press(1)?;
        self.rest(FRAMES)?;
        for step in 1..=12_u8 {
            let part = f32::from(step) / 12.0;
            self.move_to([from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])])?;
            if step == 1 {
                self.rest(FRAMES)?;
            }
        }
        self.release(1)
    }

    /// Waits until the program has nothing to do for some time, on a busy machine as well.
    fn rest(&self, time: Duration) -> io::Result<()> {
        let start = Instant::now();
        let mut since = Instant::now();
        while since.elapsed() < time && start.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(10));
            if self.is_busy()? {
                since = Instant::now();
            }
        }
        Ok(())
    }

    /// Whether a thread of the program runs, or would if it had a processor.
    fn is_busy(&self) -> io::Result<bool> {
        for thread in std::fs::read_dir(format!("/proc/{}/task", self.program))? {
            // A thread may end meanwhile. Its state follows its name, which is in brackets.
            let state = std::fs::read_to_string(thread?.path().join("stat")).unwrap_or_default();
            if state.rsplit(") ").next().is_some_and(|rest| rest.starts_with(['R', 'D'])) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Presses a key while others are held.
    pub(crate) fn key(&mut self, held: &[u8], key: u8) -> io::Result<()> {
        held.iter().try_for_each(|held| self.fake(KEY, *held, [0.0; 2]))?;
        self.fake(KEY, key, [0.0; 2])?;
        self.fake(KEY + 1, key, [0.0; 2])?;
        held.iter().rev().try_for_each(|held| self.fake(KEY + 1, *held, [0.0; 2]))
    }

    /// A part of the screen from its left upper corner.
    pub(crate) fn look(&mut self, [width, height]: [u16; 2]) -> io::Result<Screen> {
        let mut request = [0; 20];
        request[..4].copy_from_slice(&[GET_IMAGE, 2, 5, 0]);
        request[4..8].copy_from_slice(&self.root.to_le_bytes());
        request[12..14].copy_from_slice(&width.to_le_bytes());
        request[14..16].copy_from_slice(&height.to_le_bytes());
        request[16..].fill(u8::MAX);
        let (_, bytes) = self.ask(&request)?;
        let pixels = bytes.as_chunks::<4>().0.iter().map(|[b, g, r, _]| [*r, *g, *b]).collect();
        Ok(Screen { width: usize::from(width), pixels })
    }

    /// The same once it is as wanted, and half a second later still the same.
    pub(crate) fn wait(
        &mut self,
        size: [u16; 2],
        name: &str,
        is_wanted: impl Fn(&Screen) -> bool,
    ) -> io::Result<Screen> {
        self.wait_for(size, Duration::from_millis(500), name, is_wanted)
    }

    /// The same once it is as wanted, and has been still for some time.
    pub(crate) fn wait_for(
        &mut self,
        size: [u16; 2],
        still: Duration,
        name: &str,
        is_wanted: impl Fn(&Screen) -> bool,
    ) -> io::Result<Screen> {
        let start = Instant::now();
        let mut last = self.look(size)?;
        let mut since = Instant::now();
        while start.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(30));
            let now = self.look(size)?;
            if now != last || self.is_busy()? {
                (last, since) = (now, Instant::now());
            }
            if since.elapsed() >= still && is_wanted(&last) {
                return Ok(last);
            }
        }
        Err(io::Error::other(format!("it never came: {name}")))
    }
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
