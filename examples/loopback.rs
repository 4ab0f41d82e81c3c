//! A connection between two players in one process, with lag and packet loss.

use std::sync::{Arc, Mutex};

use bevy_ggrs::ggrs::{Message, NonBlockingSocket};

/// The packets in flight, shared by both ends.
#[derive(Clone, Default)]
pub(crate) struct Net(Arc<Mutex<Packets>>);

#[derive(Default)]
struct Packets {
    frame: u32,
    /// State of the random number generator.
    lot: u32,
    /// Frame of arrival, sender, receiver and message.
    under_way: Vec<(u32, usize, usize, Message)>,
}

impl Net {
    /// Advances the clock by a frame. From the first call on, packets are delayed and lost; before it the connection is perfect, so that the session can be set
    /// up.
    pub(crate) fn next_frame(&self) {
        self.0.lock().unwrap().frame += 1;
    }

    /// The end of one player.
    pub(crate) fn end(&self, me: usize) -> End {
        End(me, self.clone())
    }
}

/// One end of the connection. Packets take 2 to 5 frames, may overtake each other, and one in eight is lost.
pub(crate) struct End(usize, Net);

impl NonBlockingSocket<usize> for End {
    fn send_to(&mut self, message: &Message, to: &usize) {
        let packets = &mut *self.1.0.lock().unwrap();
        packets.lot = packets.lot.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let bad = packets.frame > 0;
        let (lost, lag) = (bad && packets.lot >> 29 == 0, 2 + (packets.lot >> 16) % 4);
        let lag = if bad { lag } else { 0 };
        if !lost {
            packets.under_way.push((packets.frame + lag, self.0, *to, message.clone()));
        }
    }

    fn receive_all_messages(&mut self) -> Vec<(usize, Message)> {
        let Packets { frame, under_way, .. } = &mut *self.1.0.lock().unwrap();
        let arrived = under_way.extract_if(.., |packet| packet.2 == self.0 && packet.0 <= *frame);
        arrived.map(|(_, from, _, message)| (from, message)).collect()
    }
}
