//! Pointer and keys: the X server generates events on request (its extension XTEST, made for testing windows), and they reach the window like those of a mouse
//! and a keyboard.

use std::cell::Cell;
use std::io::IoSlice;

use x11rb::CURRENT_TIME;
use x11rb::connection::{Connection, RequestConnection};
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt, InputFocus, Window};
use x11rb::rust_connection::RustConnection;

/// A key by its X keycode: the Linux keycode plus eight.
#[derive(Clone, Copy)]
pub(super) struct Key(pub(super) u8);

impl Key {
    pub(super) const ESCAPE: Self = Self(9);
    pub(super) const CONTROL: Self = Self(37);
    pub(super) const A: Self = Self(38);
    pub(super) const B: Self = Self(56);
    pub(super) const H: Self = Self(43);
    pub(super) const N: Self = Self(57);
    pub(super) const SPACE: Self = Self(65);
    pub(super) const ONE: Self = Self(10);
    pub(super) const F5: Self = Self(71);
    pub(super) const F9: Self = Self(75);

    /// The key that types a letter, a comma or a point on a US keyboard, which virtual screens have.
    pub(super) fn of(letter: char) -> Option<Self> {
        let rows = [("qwertyuiop", 24), ("asdfghjkl", 38), ("zxcvbnm,.", 52)];
        rows.into_iter().find_map(|(row, first)| {
            let place = row.chars().position(|one| one == letter)?;
            Some(Self(first + place as u8))
        })
    }
}

/// Types of events in the X protocol.
const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// The left button, and one notch of the wheel up or down.
pub(super) const LEFT: u8 = 1;
pub(super) const WHEEL_UP: u8 = 4;
pub(super) const WHEEL_DOWN: u8 = 5;

/// A connection that sends pointer and key events to the window.
pub(super) struct Hand {
    server: RustConnection,
    /// Major opcode of the extension.
    opcode: u8,
    root: Window,
    /// Position of the window on the screen, pixels.
    origin: [i16; 2],
    /// Last position of the pointer, pixels of the screen.
    at: Cell<Option<[i16; 2]>>,
}

impl Hand {
    /// Finds the window by its title, and gives it the keyboard focus, because a virtual screen may have no window manager to do so.
    pub(super) fn at(title: &str) -> Result<Self, String> {
        let said = |what: &str| format!("the X server {what}");
        let (server, screen) = RustConnection::connect(None).map_err(|fault| fault.to_string())?;
        let extension = server.extension_information("XTEST").ok().flatten();
        let opcode = extension.ok_or_else(|| said("has no XTEST"))?.major_opcode;
        let root = server.setup().roots[screen].root;
        let window = find(&server, root, title, 3).ok_or_else(|| said("has no such window"))?;
        let place = server.translate_coordinates(window, root, 0, 0).ok();
        let place =
            place.and_then(|place| place.reply().ok()).ok_or_else(|| said("does not answer"))?;
        let focused = server.set_input_focus(InputFocus::PARENT, window, CURRENT_TIME);
        let focused = focused.ok().and_then(|focused| focused.check().ok());
        focused.ok_or_else(|| said("does not give the window the keyboard focus"))?;
        Ok(Self { server, opcode, root, origin: [place.dst_x, place.dst_y], at: Cell::new(None) })
    }

    /// Moves the pointer to a pixel of the window. If it is already there, no event is sent: winit reports the absolute position of a warped pointer as its
    /// motion, and with a pressed button that would turn the camera.
    pub(super) fn point(&self, x: f32, y: f32) -> Result<(), String> {
        let at = Some([self.origin[0] + x as i16, self.origin[1] + y as i16]);
        if let (Some(to), false) = (at, self.at.replace(at) == at) {
            self.fake(MOTION, 0, to)?;
        }
        Ok(())
    }

    pub(super) fn button(&self, button: u8, down: bool) -> Result<(), String> {
        self.fake(if down { BUTTON_PRESS } else { BUTTON_RELEASE }, button, [0, 0])
    }

    pub(super) fn key(&self, key: Key, down: bool) -> Result<(), String> {
        self.fake(if down { KEY_PRESS } else { KEY_RELEASE }, key.0, [0, 0])
    }

    /// Sends the request `FakeInput` and waits for the server's reply, after which the event is queued.
    fn fake(&self, kind: u8, detail: u8, at: [i16; 2]) -> Result<(), String> {
        let mut request = [0; 36];
        // The opcode, and the length of the request in words of four bytes.
        (request[0], request[1], request[2]) = (self.opcode, 2, 9);
        (request[4], request[5]) = (kind, detail);
        request[12..16].copy_from_slice(&self.root.to_ne_bytes());
        request[24..26].copy_from_slice(&at[0].to_ne_bytes());
        request[26..28].copy_from_slice(&at[1].to_ne_bytes());
        let sent = self.server.send_request_without_reply(&[IoSlice::new(&request)], Vec::new());
        let sent = sent.map_err(|fault| fault.to_string())?;
        sent.check().map_err(|fault| format!("the X server refused an event: {fault}"))
    }
}

/// The window with this title below another one, at most `depth` levels down.
fn find(server: &RustConnection, within: Window, title: &str, depth: u32) -> Option<Window> {
    let children = server.query_tree(within).ok()?.reply().ok()?.children;
    children.into_iter().find_map(|child| {
        let (name, any) = (AtomEnum::WM_NAME, AtomEnum::ANY);
        let read = server.get_property(false, child, name, any, 0, 256).ok()?.reply().ok()?;
        if read.value == title.as_bytes() {
            return Some(child);
        }
        (depth > 1).then(|| find(server, child, title, depth - 1)).flatten()
    })
}
