//! The variant of iceoryx2 that is used here: all that it shares lies in one folder.
//!
//! iceoryx2's own variant for processes keeps memory under names in /dev/shm, where every user may
//! plant a name, and gives one of its files to all users. This one differs in the storage alone.

use crate::kept::Kept;
use crate::segment::Segment;
use core::fmt::Debug;
use iceoryx2::service::Service;
use iceoryx2::service::internal::ServiceInternal;
use iceoryx2::unique_id_generator::unique_system_id::UniqueSystemId;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use iceoryx2_bb_lock_free::mpmc::counting_bit_set::RelocatableCountingBitSet;
use iceoryx2_cal::event::trigger::State;
use iceoryx2_cal::event::trigger::unix_datagram_socket::GenericUnixDatagramSocketTrigger;
use iceoryx2_cal::resizable_shared_memory::dynamic::DynamicMemory;
use iceoryx2_cal::shared_memory::common::details::{AllocatorDetails, Memory};
use iceoryx2_cal::shm_allocator::bump_allocator::BumpAllocator;
use iceoryx2_cal::shm_allocator::pool_allocator::PoolAllocator;
use iceoryx2_cal::zero_copy_connection::common::details::{Connection, SharedManagementData};
use iceoryx2_cal::{bag, hash, monitoring, reactor, serialize, static_storage};

/// Memory of messages.
type Pool<A> = Memory<A, Segment<AllocatorDetails<A>>>;

/// iceoryx2 between processes that share a folder.
#[derive(Clone, Debug)]
pub(crate) struct Ipc;

impl Service for Ipc {
    type StaticStorage = static_storage::recommended::Ipc;
    type ConfigSerializer = serialize::recommended::Recommended;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Segment<T>;
    type Bag = bag::recommended::Recommended;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = Segment<T>;
    type ServiceNameHasher = hash::recommended::Recommended;
    type SharedMemory = Pool<PoolAllocator>;
    type ResizableSharedMemory = DynamicMemory<PoolAllocator, Pool<PoolAllocator>>;
    type Connection = Connection<Segment<SharedManagementData>>;
    type Event = GenericUnixDatagramSocketTrigger<
        RelocatableCountingBitSet,
        Segment<State<RelocatableCountingBitSet, ()>>,
    >;
    type Monitoring = monitoring::recommended::Ipc;
    type Reactor = reactor::recommended::Ipc;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> = Kept<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> = Segment<T>;
    type BlackboardPayload = Pool<BumpAllocator>;
    type UniqueId = UniqueSystemId;
}

impl ServiceInternal<Self> for Ipc {}
